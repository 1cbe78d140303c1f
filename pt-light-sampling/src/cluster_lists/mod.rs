//! Lists of the lights that matter in each cluster.
//!
//! A sampler at a point of a cluster picks from the cluster's list, or, with the probability `catch_all`, from all lights by their
//! power:
//!
//! ```text
//! pmf(l) = (1 - catch_all) list_pmf(l) + catch_all power_pmf(l)
//! ```
//!
//! So the estimate is unbiased whatever a list leaves out. A light is left out if
//!
//! 1. it is dark, or no point of its box emits towards any point of the cluster's box. This is exact and costs nothing;
//! 2. the bound of its irradiance in the box is less than [`ListLimits::min_share`] of the light in the cluster;
//! 3. it is hidden, if there is a [visibility estimate](VisibilityEstimate);
//! 4. the list is full: the weakest lights go.
//!
//! The last three make `catch_all` positive: it is the share of the light that they leave out.
//!
//! Distant lights reach every cluster; their bound is the irradiance of a surface that faces them.
//!
//! Lights that may change are in lists of their own, which are rebuilt in every frame in which one of them has changed.

mod boxes;
mod entries;
mod irradiance;
mod layout;
mod visibility;

pub use boxes::{ClusterBox, cluster_boxes};
pub use entries::{IndexLists, ListLimits};
pub(crate) use layout::{rank_words, ranks, subset_by_subset};
pub use visibility::VisibilityEstimate;

use crate::{EmissiveTriangle, LightBounds};
use entries::{Builder, Left};
use irradiance::Emitters;
use pt_scene::{Bounds, LightKind, Scene};

/// Decides whether any part of a light may be seen from a cluster: (cluster, light) -> visible.
pub type Visible<'a> = dyn Fn(u32, u32) -> bool + Sync + 'a;

/// Smallest [`ClusterLists::catch_all`] where a list leaves out lights that may matter. A left-out light that does matter, because an
/// estimate was wrong, then gets a weight of at most 64 times that of a choice by power; and the list loses 1.6 % of its samples.
pub const MIN_CATCH_ALL: f32 = 1.0 / 64.0;
/// Largest [`ClusterLists::catch_all`] where the list has any light: the strongest lights of a cluster get at least one half of the
/// samples, so that the error of the list's share of the light at most grows by a factor of sqrt(2).
pub const MAX_CATCH_ALL: f32 = 0.5;

/// Which lights may change from frame to frame, in the order of [`crate::local_lights`]: triangles of instances that move or deform, point and
/// spot lights that move or blink.
pub fn changing_lights(scene: &Scene, emissives: &[EmissiveTriangle]) -> Vec<bool> {
    let triangles = emissives.iter().map(|t| {
        let instance = &scene.instances[t.instance as usize];
        !instance.is_static(&scene.meshes[instance.mesh as usize])
    });
    let punctual = scene.lights.iter().filter(|light| light.kind != LightKind::Directional);
    triangles.chain(punctual.map(|light| light.motion.is_some() || light.node.is_some())).collect()
}

/// What [`ClusterLists::update`] had to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ListUpdate {
    /// No light has changed.
    Nothing,
    /// The lists of the lights that may change are new, and with them `catch_all`.
    Changing,
    /// All lists are new.
    All,
}

/// The lists of all clusters. Lights are named by their index in [`crate::local_lights`].
///
/// Memory: 4 bytes per entry, 53 per light, 64 per cluster. While the lists are built, 52 bytes per light more, and 8 per light and
/// thread: 2 million lights take about 100 MB, and 230 MB while they are built.
#[derive(Clone, Debug, PartialEq)]
pub struct ClusterLists {
    /// Lights that do not change.
    pub fixed: IndexLists,
    /// Lights that may change, as they are now.
    pub changing: IndexLists,
    /// For each cluster the probability of a pick from all lights. 0: the lists have every light that reaches the cluster. 1: they
    /// are empty, but some light may reach it.
    pub catch_all: Vec<f32>,
    boxes: Vec<ClusterBox>,
    limits: ListLimits,
    lights: Vec<LightBounds>,
    may_change: Vec<bool>,
    fixed_left: Vec<Left>,
}

impl ClusterLists {
    /// Builds the lists. `may_change` says which lights may change from frame to frame; missing values mean false. `visible` is asked
    /// about those that do not.
    ///
    /// All cores are used; the result does not depend on their number.
    pub fn new(
        boxes: Vec<ClusterBox>,
        lights: &[LightBounds],
        may_change: &[bool],
        limits: ListLimits,
        visible: Option<&Visible>,
    ) -> Self {
        let mut may_change = may_change.to_vec();
        may_change.resize(lights.len(), false);
        let fixed = indices(&may_change, false);
        let emitters = Emitters::new(fixed.iter().map(|&i| &lights[i as usize]));
        let builder =
            Builder { boxes: &boxes, emitters: &emitters, names: &fixed, limits, visible, before: &[] };
        let (fixed, fixed_left) = builder.build();
        let mut lists = Self {
            fixed,
            changing: IndexLists::default(),
            catch_all: Vec::new(),
            boxes,
            limits,
            lights: lights.to_vec(),
            may_change,
            fixed_left,
        };
        lists.build_changing();
        lists
    }

    /// Brings the lists to the state of `lights`: afterwards they equal new ones, bit for bit.
    ///
    /// Only the lists of the lights that may change are rebuilt, in a time that is proportional to the number of these lights and of
    /// clusters. Triangles that deform should have the bounds of their present pose ([`Scene::pose_meshes`]), but other bounds only
    /// add variance: no test rejects them by where they are. If another light has changed, or which lights there are, all lists are
    /// rebuilt, with `visible`; that takes as long as [`ClusterLists::new`].
    pub fn update(
        &mut self,
        lights: &[LightBounds],
        may_change: &[bool],
        visible: Option<&Visible>,
    ) -> ListUpdate {
        let flags = may_change.iter().copied().chain(std::iter::repeat(false)).take(lights.len());
        let same_lights = lights.len() == self.lights.len() && flags.eq(self.may_change.iter().copied());
        let mut changed = false;
        let same_fixed = same_lights
            && self.lights.iter().zip(lights).zip(&self.may_change).all(|((old, new), &may_change)| {
                let same = bits(old) == bits(new);
                changed |= !same;
                same || may_change
            });
        if !same_fixed {
            let boxes = std::mem::take(&mut self.boxes);
            *self = Self::new(boxes, lights, may_change, self.limits, visible);
            ListUpdate::All
        } else if changed {
            self.lights.copy_from_slice(lights);
            self.build_changing();
            ListUpdate::Changing
        } else {
            ListUpdate::Nothing
        }
    }

    /// Number of clusters.
    pub fn count(&self) -> usize {
        self.boxes.len()
    }

    fn build_changing(&mut self) {
        let names = indices(&self.may_change, true);
        let emitters = Emitters::new(names.iter().map(|&i| &self.lights[i as usize]));
        let builder = Builder {
            boxes: &self.boxes,
            emitters: &emitters,
            names: &names,
            limits: self.limits,
            visible: None,
            before: &self.fixed_left,
        };
        let (changing, changing_left) = builder.build();
        let catch_all = |(cluster, (a, b)): (usize, (&Left, &Left))| {
            let empty = self.fixed.list(cluster).is_empty() && changing.list(cluster).is_empty();
            a.with(b).catch_all(empty)
        };
        self.catch_all = self.fixed_left.iter().zip(&changing_left).enumerate().map(catch_all).collect();
        self.changing = changing;
    }
}

fn indices(may_change: &[bool], value: bool) -> Vec<u32> {
    (0..).zip(may_change).filter(|&(_, &flag)| flag == value).map(|(index, _)| index).collect()
}

/// All values of a light, so that a NaN equals itself.
fn bits(light: &LightBounds) -> [u32; 13] {
    let (Bounds { min, max }, axis) = (light.bounds, light.axis);
    let rest = [light.cos_spread, light.cos_emission, light.power];
    let [a, b, c, d] = [min.to_array(), max.to_array(), axis.to_array(), rest].map(|v| v.map(f32::to_bits));
    let e = light.irradiance.to_bits();
    [a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2], d[0], d[1], d[2], e]
}
