//! Animation on the CPU: node hierarchies over time (glTF 2.0, section 3.11), and the vertices of meshes that deform.
//!
//! A [`Rig`] is a pure function of time: the same second gives the same bits, so that the previous pose of a frame is the current one
//! of the frame before.

mod deform;
mod sampler;

pub use deform::{Deformation, DeformedVertices, Influence, MorphDelta, Skin, VertexLists};
pub use sampler::{Interpolation, Sampler, unit};

use glam::{Affine3A, Quat, Vec3};
use std::ops::Range;
use std::sync::Arc;

use crate::transform::thicken;

/// Which of a file's animations play.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum AnimationChoice {
    /// The first, and with it every other one that moves nothing that is moved already.
    #[default]
    Compatible,
    /// All; of two that move the same, the later one counts.
    All,
    /// None: nodes rest.
    None,
    /// The one of this index, from 0.
    Index(usize),
    /// The one of this name.
    Name(String),
}

impl std::str::FromStr for AnimationChoice {
    type Err = String;

    /// `all`, `none`, an index from 0, anything else is a name.
    fn from_str(text: &str) -> Result<Self, String> {
        match (text, text.parse()) {
            ("", _) => Err("expected all, none, a name or an index from 0".into()),
            ("all", _) => Ok(Self::All),
            ("none", _) => Ok(Self::None),
            (_, Ok(index)) => Ok(Self::Index(index)),
            _ => Ok(Self::Name(text.into())),
        }
    }
}

/// What an animation does after its last key.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AnimationEnd {
    /// It starts again at time 0 of the animation. The frame after the last pose has the first one, and its motion vectors lead
    /// back to the last pose, where everything was in the frame before.
    #[default]
    Loop,
    /// It keeps the pose of the last key.
    Hold,
}

impl std::str::FromStr for AnimationEnd {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "loop" => Ok(Self::Loop),
            "hold" => Ok(Self::Hold),
            _ => Err("expected loop or hold".into()),
        }
    }
}

/// An animation of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct AnimationInfo {
    /// Name by which it is chosen; may be empty.
    pub name: String,
    /// Seconds from 0 to its last key; [`AnimationEnd`] says what comes after it.
    pub duration: f64,
    /// Properties of nodes that it moves.
    pub channels: usize,
    /// Whether it plays.
    pub plays: bool,
}

/// The target of a [`Track`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Property {
    /// Metres.
    Translation,
    /// Unit quaternion.
    Rotation,
    /// Factors.
    Scale,
    /// Weights of the mesh's morph targets.
    Weights,
}

/// One property of a node over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Node that is moved.
    pub node: u32,
    /// What of it.
    pub property: Property,
    /// Its values.
    pub sampler: Sampler,
    /// Seconds after which the animation that it belongs to starts again; 0: it does not, and the last key holds.
    pub period: f64,
}

/// A node's place relative to its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trs {
    /// Metres.
    pub translation: Vec3,
    /// Unit quaternion.
    pub rotation: Quat,
    /// Factors.
    pub scale: Vec3,
}

impl From<Trs> for Affine3A {
    /// A scale of zero along one axis keeps a small thickness, see [`thicken`].
    fn from(t: Trs) -> Self {
        Self::from_scale_rotation_translation(thicken(t.scale), t.rotation, t.translation)
    }
}

/// How a node rests.
#[derive(Clone, Debug, PartialEq)]
pub struct RigNode {
    /// The node that it hangs on.
    pub parent: Option<u32>,
    /// Its matrix relative to the parent.
    pub local: Affine3A,
    /// The same in parts, which is what animation moves.
    pub trs: Trs,
    /// Weights of its mesh's morph targets.
    pub weights: Vec<f32>,
}

/// A hierarchy of nodes and the tracks that move them.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    nodes: Vec<RigNode>,
    /// Sorted by node.
    tracks: Vec<Track>,
    /// Tracks of each node.
    tracks_of: Vec<Range<usize>>,
    /// Nodes that move or hang on one that does, parents first.
    moving: Vec<u32>,
    moves: Vec<bool>,
    rest: Pose,
}

/// Where all nodes of a [`Rig`] are at one time. Reused from frame to frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    /// World-from-node transforms.
    pub world: Vec<Affine3A>,
    /// Weights of the morph targets, by node.
    pub weights: Vec<Vec<f32>>,
}

impl Rig {
    /// A rig of `nodes`. Of two tracks with the same target the later one counts.
    ///
    /// # Errors
    /// The index of a node that is its own ancestor, or of one whose parent or track's node does not exist.
    pub fn new(nodes: Vec<RigNode>, mut tracks: Vec<Track>) -> Result<Self, usize> {
        let order = parents_first(&nodes)?;
        if let Some(track) = tracks.iter().find(|t| t.node as usize >= nodes.len()) {
            return Err(track.node as usize);
        }
        tracks.reverse();
        tracks.sort_by_key(|t| (t.node, t.property));
        tracks.dedup_by_key(|t| (t.node, t.property));
        let tracks_of: Vec<_> = (0..nodes.len() as u32)
            .map(|n| tracks.partition_point(|t| t.node < n)..tracks.partition_point(|t| t.node <= n))
            .collect();
        let mut rest = Pose {
            world: vec![Affine3A::IDENTITY; nodes.len()],
            weights: nodes.iter().map(|n| n.weights.clone()).collect(),
        };
        let mut moves = vec![false; nodes.len()];
        for &n in &order {
            let (node, n) = (&nodes[n as usize], n as usize);
            let parent = node.parent.map(|p| p as usize);
            rest.world[n] = parent.map_or(node.local, |p| rest.world[p] * node.local);
            moves[n] = !tracks_of[n].is_empty() || parent.is_some_and(|p| moves[p]);
        }
        let moving = order.into_iter().filter(|&n| moves[n as usize]).collect();
        Ok(Self { nodes, tracks, tracks_of, moving, moves, rest })
    }

    /// Where the nodes are without animation.
    pub fn rest(&self) -> &Pose {
        &self.rest
    }

    /// Whether a node's transform or weights ever change.
    pub fn moves(&self, node: u32) -> bool {
        self.moves.get(node as usize).copied().unwrap_or(false)
    }

    /// Whether anything changes.
    pub fn is_animated(&self) -> bool {
        !self.moving.is_empty()
    }

    /// Brings `pose` to `time` (seconds). Animations start again after their period, before time 0 too.
    pub fn evaluate(&self, time: f64, pose: &mut Pose) {
        if pose.world.len() != self.nodes.len() {
            pose.clone_from(&self.rest);
        }
        for &n in &self.moving {
            let parent = self.nodes[n as usize].parent;
            let local = self.local(n, time, &mut pose.weights[n as usize]);
            pose.world[n as usize] = parent.map_or(local, |p| pose.world[p as usize] * local);
        }
    }

    /// World-from-node transform of one node at `time`: the bits of [`Self::evaluate`].
    pub fn world_at(&self, node: u32, time: f64) -> Affine3A {
        let parent = |&n: &u32| self.nodes[n as usize].parent;
        let mut chain: Vec<u32> =
            std::iter::successors(Some(node), parent).take_while(|&n| self.moves(n)).collect();
        let still = chain.last().map_or(Some(node), parent);
        let mut world = still.map(|n| self.rest.world[n as usize]);
        while let Some(n) = chain.pop() {
            let local = self.local(n, time, &mut []);
            world = Some(world.map_or(local, |w| w * local));
        }
        world.unwrap_or_default()
    }

    fn local(&self, node: u32, time: f64, weights: &mut [f32]) -> Affine3A {
        let rest = &self.nodes[node as usize];
        let tracks = &self.tracks[self.tracks_of[node as usize].clone()];
        let mut trs = rest.trs;
        let mut placed = false;
        for track in tracks {
            let time = if track.period > 0.0 { time.rem_euclid(track.period) } else { time };
            let mut vector = [0.0; 3];
            match track.property {
                Property::Rotation => trs.rotation = track.sampler.sample_rotation(time),
                Property::Weights => track.sampler.sample(time, weights),
                Property::Translation | Property::Scale => track.sampler.sample(time, &mut vector),
            }
            match track.property {
                Property::Translation => trs.translation = vector.into(),
                Property::Scale => trs.scale = vector.into(),
                Property::Rotation | Property::Weights => {}
            }
            placed |= track.property != Property::Weights;
        }
        if placed { trs.into() } else { rest.local }
    }
}

/// All nodes, each after its parent; the index of one that has none of its ancestors as root, if there is one.
fn parents_first(nodes: &[RigNode]) -> Result<Vec<u32>, usize> {
    let mut children = vec![Vec::new(); nodes.len()];
    let mut order = Vec::with_capacity(nodes.len());
    for (n, node) in (0..).zip(nodes) {
        match node.parent {
            Some(p) => children.get_mut(p as usize).ok_or(n as usize)?.push(n),
            None => order.push(n),
        }
    }
    let mut next = 0;
    while let Some(&n) = order.get(next) {
        order.append(&mut children[n as usize]);
        next += 1;
    }
    match children.iter().position(|c| !c.is_empty()) {
        Some(lost) => Err(lost),
        None => Ok(order),
    }
}

/// Follows a node of a rig.
#[derive(Clone)]
pub struct NodeMotion {
    rig: Arc<Rig>,
    node: u32,
}

impl NodeMotion {
    /// The motion of `node`; `None` when it stands still.
    pub fn new(rig: &Arc<Rig>, node: u32) -> Option<Self> {
        rig.moves(node).then(|| Self { rig: rig.clone(), node })
    }

    /// World-from-node transform at `time` (seconds).
    pub fn at(&self, time: f64) -> Affine3A {
        self.rig.world_at(self.node, time)
    }
}

impl PartialEq for NodeMotion {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.rig, &other.rig) && self.node == other.node
    }
}

impl std::fmt::Debug for NodeMotion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "node {}", self.node)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(parent: Option<u32>, translation: Vec3) -> RigNode {
        let trs = Trs { translation, rotation: Quat::IDENTITY, scale: Vec3::ONE };
        RigNode { parent, local: trs.into(), trs, weights: vec![] }
    }

    fn track(node: u32, property: Property, times: &[f32], values: &[f32]) -> Track {
        let width = values.len() / times.len();
        let sampler = Sampler::new(times.to_vec(), values.to_vec(), width, Interpolation::Linear).unwrap();
        Track { node, property, period: sampler.end(), sampler }
    }

    /// A child listed before its parent, which turns about +Y once in four seconds.
    fn rig() -> Rig {
        let quarter = |i: u32| Quat::from_rotation_y(std::f32::consts::FRAC_PI_2 * i as f32).to_array();
        let turn =
            track(1, Property::Rotation, &[0.0, 1.0, 2.0, 3.0, 4.0], &[0, 1, 2, 3, 4].map(quarter).concat());
        let slide = track(0, Property::Translation, &[0.0, 4.0], &[1.0, 0.0, 0.0, 3.0, 0.0, 0.0]);
        Rig::new(vec![node(Some(1), Vec3::X), node(None, Vec3::Y), node(None, Vec3::Z)], vec![slide, turn])
            .unwrap()
    }

    #[test]
    fn children_follow_their_parents() {
        let rig = rig();
        let mut pose = Pose::default();
        rig.evaluate(1.0, &mut pose);
        // A quarter turn takes +X to -Z; the child is 1.5 m out by now.
        let child = Vec3::from(pose.world[0].translation);
        assert!(child.abs_diff_eq(Vec3::new(0.0, 1.0, -1.5), 1e-5), "{child}");
        assert_eq!(pose.world[2], Affine3A::from_translation(Vec3::Z));
        assert_eq!([0, 1, 2].map(|n| rig.moves(n)), [true, true, false]);
        assert_eq!(rig.rest().world[0], Affine3A::from_translation(Vec3::new(1.0, 1.0, 0.0)));
    }

    #[test]
    fn time_wraps_and_repeats_to_the_bit() {
        let rig = rig();
        let (mut a, mut b) = (Pose::default(), Pose::default());
        for time in [0.25, 3.75, 9.5, -1.25] {
            rig.evaluate(time, &mut a);
            rig.evaluate(time + 4.0, &mut b);
            assert_eq!(a, b);
            rig.evaluate(17.3, &mut b);
            rig.evaluate(time, &mut b);
            assert_eq!(a, b, "a pose depends on the one before");
            for n in 0..3 {
                assert_eq!(rig.world_at(n, time), a.world[n as usize]);
            }
        }
    }

    #[test]
    fn the_later_track_counts() {
        let tracks = [1.0, 2.0].map(|x| track(0, Property::Scale, &[0.0], &[x, x, x]));
        let rig = Rig::new(vec![node(None, Vec3::ZERO)], tracks.to_vec()).unwrap();
        assert_eq!(rig.world_at(0, 0.0), Affine3A::from_scale(Vec3::splat(2.0)));
    }

    #[test]
    fn cycles_and_strangers_are_refused() {
        assert_eq!(Rig::new(vec![node(Some(1), Vec3::X), node(Some(0), Vec3::X)], vec![]), Err(0));
        assert_eq!(Rig::new(vec![node(Some(7), Vec3::X)], vec![]), Err(0));
        assert_eq!(Rig::new(vec![], vec![track(3, Property::Scale, &[0.0], &[1.0; 3])]), Err(3));
    }

    #[test]
    fn choices_are_parsed() {
        assert_eq!("all".parse(), Ok(AnimationChoice::All));
        assert_eq!("none".parse(), Ok(AnimationChoice::None));
        assert_eq!("2".parse(), Ok(AnimationChoice::Index(2)));
        assert_eq!("Walk".parse(), Ok(AnimationChoice::Name("Walk".into())));
        assert!("".parse::<AnimationChoice>().is_err());
        assert_eq!(["loop", "hold"].map(str::parse), [Ok(AnimationEnd::Loop), Ok(AnimationEnd::Hold)]);
        assert!("stop".parse::<AnimationEnd>().is_err());
    }
}
