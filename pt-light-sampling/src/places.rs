//! Places of punctual lights in the tables: a light keeps its place as long as it exists.

use pt_scene::Light;
use std::collections::{HashMap, HashSet};

/// A light's id, and how many lights before it have the same.
type Key = (u32, u32);

/// The places of the lights of one group: of the directional lights, or of the point and spot lights.
///
/// A light that appears takes the first place that was free before the frame, or a new one. So the place of a light that has just vanished
/// stays dark for a frame: a choice of the last frame finds no other light there.
#[derive(Clone, Debug, Default)]
pub(crate) struct Places {
    by_place: Vec<Option<Key>>,
    /// Whether other lights have been there, or none.
    has_changed: Vec<bool>,
    /// The lights that there are, in the scene's order, and their places.
    present: Vec<Key>,
    order: Vec<usize>,
}

impl Places {
    /// Places for these lights, in their order.
    pub(crate) fn new<'a>(lights: impl Iterator<Item = &'a Light>) -> Self {
        let mut places = Self::default();
        places.update(lights);
        places.has_changed.fill(false);
        places
    }

    /// Gives lights that have appeared a place and frees the places of those that have vanished; whether there are any.
    pub(crate) fn update<'a>(&mut self, lights: impl Iterator<Item = &'a Light>) -> bool {
        let mut equals: HashMap<u32, u32> = HashMap::new();
        let key = |light: &Light| {
            let count = equals.entry(light.id).or_default();
            *count += 1;
            (light.id, *count - 1)
        };
        let present: Vec<Key> = lights.map(key).collect();
        if present == self.present {
            return false;
        }
        let mut free: Vec<usize> =
            (0..self.by_place.len()).rev().filter(|&i| self.by_place[i].is_none()).collect();
        let exists: HashSet<Key> = present.iter().copied().collect();
        for (key, has_changed) in self.by_place.iter_mut().zip(&mut self.has_changed) {
            if key.is_some_and(|key| !exists.contains(&key)) {
                *key = None;
                *has_changed = true;
            }
        }
        let known: HashMap<Key, usize> =
            (0..).zip(&self.by_place).filter_map(|(i, key)| Some(((*key)?, i))).collect();
        self.order.clear();
        for &key in &present {
            let place = known.get(&key).copied().unwrap_or_else(|| {
                let place = free.pop().unwrap_or(self.by_place.len());
                if place == self.by_place.len() {
                    self.by_place.push(None);
                    self.has_changed.push(true);
                }
                self.by_place[place] = Some(key);
                place
            });
            self.order.push(place);
        }
        self.present = present;
        true
    }

    /// How many places there are, free ones too.
    pub(crate) fn count(&self) -> usize {
        self.by_place.len()
    }

    /// Whether a place has had another light than now, or none.
    pub(crate) fn has_changed(&self, place: usize) -> bool {
        self.has_changed[place]
    }

    /// The lights by their places; they are those of the last update.
    pub(crate) fn arranged<'a>(&self, lights: impl Iterator<Item = &'a Light>) -> Vec<Option<&'a Light>> {
        let mut arranged = vec![None; self.by_place.len()];
        for (&place, light) in self.order.iter().zip(lights) {
            arranged[place] = Some(light);
        }
        arranged
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn lights(ids: &[u32]) -> Vec<Light> {
        let light = |&id: &u32| Light { id, ..Light::point("lamp", Vec3::ZERO, Vec3::splat(id as f32)) };
        ids.iter().map(light).collect()
    }

    /// Ids by place, 0: nobody.
    fn step(places: &mut Places, ids: &[u32]) -> Vec<u32> {
        let lights = lights(ids);
        places.update(lights.iter());
        places.arranged(lights.iter()).iter().map(|light| light.map_or(0, |light| light.id)).collect()
    }

    #[test]
    fn lights_keep_their_places_while_they_exist() {
        let mut places = Places::new(lights(&[5, 6, 7]).iter());
        assert_eq!(step(&mut places, &[7, 5]), [5, 0, 7]);
        assert_eq!([0, 1, 2].map(|i| places.has_changed(i)), [false, true, false]);
        assert_eq!(step(&mut places, &[8, 7, 5]), [5, 8, 7], "a free place is taken");
        assert_eq!(
            step(&mut places, &[8, 9, 5]),
            [5, 8, 0, 9],
            "that of a light that has just vanished is not"
        );
        assert_eq!(step(&mut places, &[8, 9, 5, 7]), [5, 8, 7, 9]);
        assert_eq!(step(&mut places, &[]), [0; 4]);
    }

    #[test]
    fn equal_ids_are_told_apart_by_their_order() {
        let mut places = Places::new(lights(&[1, 1, 1]).iter());
        assert_eq!(places.count(), 3);
        assert_eq!(step(&mut places, &[1, 1]), [1, 1, 0]);
        assert_eq!(step(&mut places, &[1, 1]), [1, 1, 0]);
    }
}
