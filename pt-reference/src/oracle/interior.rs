//! Solids that a path is inside of (Schmidt and Budge 2002). The order of strength is described in interior.glsl.

use std::cmp::{Ordering, Reverse};

/// Entries that a list has room for.
pub const CAPACITY: usize = 4;

/// A body of a dielectric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// Its material.
    pub material: u32,
    /// 0..=255.
    pub priority: u32,
    /// Index of refraction.
    pub ior: f32,
}

impl Solid {
    fn strength(&self, other: &Self) -> Ordering {
        (self.priority.cmp(&other.priority))
            .then(self.ior.total_cmp(&other.ior))
            .then(Reverse(self.material).cmp(&Reverse(other.material)))
    }

    fn is_same(&self, other: &Self) -> bool {
        (self.material, self.priority) == (other.material, other.priority)
    }
}

/// The two sides of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Boundary {
    /// Whose surface it is.
    pub behind: Solid,
    /// What ends where it begins, if anything does.
    pub front: Option<Solid>,
}

/// What is on both sides of a boundary, seen along the path; `None`: vacuum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Where the path comes from.
    pub here: Option<Solid>,
    /// And where it leads to.
    pub beyond: Option<Solid>,
}

impl Crossing {
    /// Whether there is nothing to be seen.
    pub fn is_false_hit(&self) -> bool {
        match (self.here, self.beyond) {
            (Some(a), Some(b)) => a.is_same(&b),
            (None, None) => true,
            _ => false,
        }
    }

    /// Index of refraction beyond over that here.
    pub fn eta(&self) -> f32 {
        let ior = |s: Option<Solid>| s.map_or(1.0, |s| s.ior);
        ior(self.beyond) / ior(self.here)
    }
}

/// The list.
#[derive(Clone, Debug, Default)]
pub struct InteriorList(Vec<Solid>);

impl InteriorList {
    /// The solid that is there.
    pub fn top(&self) -> Option<Solid> {
        self.0.iter().copied().max_by(Solid::strength)
    }

    /// All of them, in no order.
    pub fn solids(&self) -> &[Solid] {
        &self.0
    }

    /// Whether the path has entered it.
    pub fn holds(&self, solid: &Solid) -> bool {
        self.0.iter().any(|s| s.is_same(solid))
    }

    /// Adds a solid; too many: the weakest is dropped.
    pub fn add(&mut self, solid: Solid) {
        self.0.push(solid);
        if self.0.len() > CAPACITY {
            let weakest = (0..self.0.len()).min_by(|&a, &b| self.0[a].strength(&self.0[b]));
            weakest.map(|i| self.0.remove(i));
        }
    }

    fn remove(&mut self, solid: &Solid) {
        if let Some(i) = self.0.iter().position(|s| s.is_same(solid)) {
            self.0.remove(i);
        }
    }

    /// Light passes the boundary.
    pub fn cross(&mut self, boundary: &Boundary, entering: bool) {
        let (from, to) = match entering {
            true => (boundary.front, Some(boundary.behind)),
            false => (Some(boundary.behind), boundary.front),
        };
        from.inspect(|s| self.remove(s));
        if let Some(s) = to {
            self.add(s);
        }
    }

    /// What is on both sides.
    pub fn crossing(&self, boundary: &Boundary, entering: bool) -> Crossing {
        let left = if entering { boundary.front } else { Some(boundary.behind) };
        let unknown = left.filter(|s| !self.holds(s));
        let here = self.top().into_iter().chain(unknown).max_by(Solid::strength);
        let mut after = self.clone();
        after.cross(boundary, entering);
        Crossing { here, beyond: after.top() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GLASS: Solid = Solid { material: 1, priority: 2, ior: 1.5 };
    const WATER: Solid = Solid { material: 2, priority: 1, ior: 1.33 };
    const ICE: Solid = Solid { material: 3, priority: 3, ior: 1.31 };

    fn of(behind: Solid) -> Boundary {
        Boundary { behind, front: None }
    }

    /// A list, and what every boundary showed: (here, beyond) or none for a false hit.
    fn walk(events: &[(Boundary, bool)]) -> (InteriorList, Vec<Option<(f32, f32)>>) {
        let mut list = InteriorList::default();
        let seen = events.iter().map(|(boundary, entering)| {
            let crossing = list.crossing(boundary, *entering);
            list.cross(boundary, *entering);
            let ior = |s: Option<Solid>| s.map_or(1.0, |s| s.ior);
            (!crossing.is_false_hit()).then(|| (ior(crossing.here), ior(crossing.beyond)))
        });
        let seen = seen.collect();
        (list, seen)
    }

    /// Water that reaches into the wall of its glass, with ice in it: the surfaces in the wall are not there.
    #[test]
    fn liquid_in_a_glass() {
        let (list, seen) = walk(&[
            (of(GLASS), true),
            (of(WATER), true),
            (of(GLASS), false),
            (of(ICE), true),
            (of(ICE), false),
            (of(GLASS), true),
            (of(WATER), false),
            (of(GLASS), false),
        ]);
        let expected = [
            Some((1.0, 1.5)),
            None,
            Some((1.5, 1.33)),
            Some((1.33, 1.31)),
            Some((1.31, 1.33)),
            Some((1.33, 1.5)),
            None,
            Some((1.5, 1.0)),
        ];
        assert_eq!(seen, expected);
        assert_eq!(list.top(), None);
    }

    /// The same as an interface: one surface that ends the glass and begins the water.
    #[test]
    fn interface_of_two_solids() {
        let interface = Boundary { behind: WATER, front: Some(GLASS) };
        let (list, seen) =
            walk(&[(of(GLASS), true), (interface, true), (interface, false), (of(GLASS), false)]);
        assert_eq!(seen, [Some((1.0, 1.5)), Some((1.5, 1.33)), Some((1.33, 1.5)), Some((1.5, 1.0))]);
        assert_eq!(list.top(), None);
    }

    /// What overlaps of one material is one body.
    #[test]
    fn two_bodies_of_one_material() {
        let (_, seen) = walk(&[(of(GLASS), true), (of(GLASS), true), (of(GLASS), false), (of(GLASS), false)]);
        assert_eq!(seen, [Some((1.0, 1.5)), None, None, Some((1.5, 1.0))]);
    }

    /// Equal priorities: the index decides, whichever was entered first.
    #[test]
    fn order_of_entry_does_not_count() {
        let water = Solid { priority: 2, ..WATER };
        let (_, seen) = walk(&[(of(GLASS), true), (of(water), true), (of(GLASS), false), (of(water), false)]);
        assert_eq!(seen, [Some((1.0, 1.5)), None, Some((1.5, 1.33)), Some((1.33, 1.0))]);
        let (_, seen) = walk(&[(of(water), true), (of(GLASS), true), (of(water), false), (of(GLASS), false)]);
        assert_eq!(seen, [Some((1.0, 1.33)), Some((1.33, 1.5)), None, Some((1.5, 1.0))]);
    }

    /// A camera inside, an open mesh, or an entry that was dropped: leaving shows the back of the material.
    #[test]
    fn leaving_what_was_not_entered() {
        let (_, seen) = walk(&[(of(GLASS), false)]);
        assert_eq!(seen, [Some((1.5, 1.0))]);
        let (_, seen) = walk(&[(of(GLASS), true), (of(WATER), false), (of(GLASS), false)]);
        assert_eq!(seen, [Some((1.0, 1.5)), None, Some((1.5, 1.0))]);
    }

    /// More than the list holds: the strongest four are right, and the end is the vacuum again.
    #[test]
    fn overflow_drops_the_weakest() {
        let solid = |k: u32| Solid { material: k, priority: k, ior: 1.0 + 0.1 * k as f32 };
        let nested = (1..=6).map(|k| (of(solid(k)), true));
        let (list, seen) =
            walk(&nested.chain((1..=6).rev().map(|k| (of(solid(k)), false))).collect::<Vec<_>>());
        assert_eq!(list.top(), None);
        assert!(seen.iter().all(Option::is_some));
        let ior = |pair: Option<(f32, f32)>| pair.map(|p| p.0);
        assert_eq!(
            seen[6..].iter().copied().map(ior).collect::<Vec<_>>(),
            [1.6, 1.5, 1.4, 1.3, 1.2, 1.1].map(Some)
        );
    }
}
