//! Which images of a frame share memory: those whose content is needed one after the other.
//!
//! Time counts the stages of a frame in the order in which they run. An image that lives within a frame takes the place of another of the same
//! size whose time is over, or of last frame's content of one, which nothing reads from some stage on (interval partitioning: Kleinberg and Tardos,
//! Algorithm Design, section 4.1).

use pt_shaders::channels::Format;

/// From when to when the content of an image is needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Life {
    /// In every frame: what it holds stays until the next one.
    Always,
    /// The same, and this frame's is written after last frame's has been read.
    Kept,
    /// Always, in two images: this frame's is written from a stage on, last frame's is read until another one.
    Twice { from: usize, previous_until: usize },
    /// From one stage to another.
    Within { from: usize, until: usize },
}

/// An image that a frame needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wish {
    pub(crate) extent: [u32; 2],
    pub(crate) format: Format,
    pub(crate) life: Life,
}

impl Wish {
    /// Bytes of its own memory.
    pub(crate) fn bytes(&self) -> u64 {
        let copies = if matches!(self.life, Life::Twice { .. }) { 2 } else { 1 };
        copies * image_bytes(self.extent, self.format)
    }

    fn can_hold(&self, other: &Self) -> bool {
        self.extent == other.extent && self.format.bytes() == other.format.bytes()
    }
}

/// Bytes of the texels of an image.
pub(crate) fn image_bytes(extent: [u32; 2], format: Format) -> u64 {
    u64::from(extent[0]) * u64::from(extent[1]) * u64::from(format.bytes())
}

/// Where an image is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// In memory of its own, which images of other formats may use too.
    Own { other_formats: bool },
    /// In the memory of the wish with the number `host`, before this frame's content is written into it, or, with `previous`, after last frame's has been
    /// read.
    In { host: usize, previous: bool },
}

/// Memory with the times at which it is taken.
struct Memory {
    owner: usize,
    previous: bool,
    taken: Vec<[usize; 2]>,
}

/// Behind all stages.
pub(crate) const LAST: usize = usize::MAX;

/// The place of each image.
pub(crate) fn places(wishes: &[Wish]) -> Vec<Place> {
    let mut places = vec![Place::Own { other_formats: false }; wishes.len()];
    let mut memories: Vec<Memory> = Vec::new();
    for (owner, wish) in wishes.iter().enumerate() {
        if let Life::Twice { from, previous_until } = wish.life {
            memories.push(Memory { owner, previous: true, taken: vec![[0, previous_until]] });
            memories.push(Memory { owner, previous: false, taken: vec![[from, LAST]] });
        }
    }
    let mut within: Vec<(usize, [usize; 2])> = Vec::new();
    for (number, wish) in wishes.iter().enumerate() {
        if let Life::Within { from, until } = wish.life {
            within.push((number, [from, until]));
        }
    }
    within.sort_by_key(|&(number, [from, _])| (from, number));
    for (number, time) in within {
        let wish = &wishes[number];
        let is_free = |memory: &&mut Memory| {
            let apart = |taken: &[usize; 2]| taken[1] < time[0] || time[1] < taken[0];
            wishes[memory.owner].can_hold(wish) && memory.taken.iter().all(apart)
        };
        // Views of another format are the second choice.
        let differs = |memory: &&mut Memory| wishes[memory.owner].format != wish.format;
        match memories.iter_mut().filter(is_free).min_by_key(differs) {
            Some(memory) => {
                memory.taken.push(time);
                places[number] = Place::In { host: memory.owner, previous: memory.previous };
                if wishes[memory.owner].format != wish.format {
                    places[memory.owner] = Place::Own { other_formats: true };
                }
            }
            None => memories.push(Memory { owner: number, previous: false, taken: vec![time] }),
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    const OWN: Place = Place::Own { other_formats: false };

    fn wish(format: Format, life: Life) -> Wish {
        Wish { extent: [8, 4], format, life }
    }

    fn within(from: usize, until: usize) -> Life {
        Life::Within { from, until }
    }

    const fn in_place_of(host: usize) -> Place {
        Place::In { host, previous: false }
    }

    #[test]
    fn images_that_follow_each_other_share_and_those_that_meet_do_not() {
        let color = |life| wish(Format::Rgba32F, life);
        assert_eq!(places(&[color(within(0, 2)), color(within(3, 4))]), [OWN, in_place_of(0)]);
        // A stage reads the one and writes the other.
        assert_eq!(places(&[color(within(0, 3)), color(within(3, 4))]), [OWN, OWN]);
        assert_eq!(places(&[color(Life::Always), color(within(3, 4))]), [OWN, OWN]);
        // The last one may take either place; all three at once need three.
        let four = [within(0, 1), within(0, 5), within(2, 5), within(2, 3)].map(color);
        assert_eq!(places(&four), [OWN, OWN, in_place_of(0), OWN]);
        assert_eq!(places(&[color(within(0, LAST)), color(within(3, LAST))]), [OWN, OWN]);
    }

    #[test]
    fn histories_have_room_before_they_are_written_and_after_they_were_read() {
        let color = |life| wish(Format::Rgba32F, life);
        let history = color(Life::Twice { from: 2, previous_until: 2 });
        assert_eq!(places(&[history, color(within(2, 3))]), [OWN, OWN]);
        let before = color(within(0, 1));
        let after = color(within(3, LAST));
        assert_eq!(
            places(&[after, history, before]),
            [Place::In { host: 1, previous: true }, OWN, Place::In { host: 1, previous: false }]
        );
        // One that is needed before and after.
        assert_eq!(places(&[history, color(within(1, 3))]), [OWN, OWN]);
    }

    #[test]
    fn only_images_of_one_size_share() {
        let small = Wish { extent: [4, 4], ..wish(Format::Rgba32F, within(2, 3)) };
        assert_eq!(places(&[wish(Format::Rgba32F, within(0, 1)), small]), [OWN, OWN]);
        let half = wish(Format::Rgba16F, within(2, 3));
        assert_eq!(places(&[wish(Format::Rgba32F, within(0, 1)), half]), [OWN, OWN]);
        let shared = Place::Own { other_formats: true };
        assert_eq!(places(&[wish(Format::Rg32Uint, within(0, 1)), half]), [shared, in_place_of(0)]);
        let three = [wish(Format::Rg32Uint, within(0, 1)), wish(Format::Rgba16F, within(0, 1)), half];
        assert_eq!(places(&three), [OWN, OWN, in_place_of(1)], "the same format first");
    }
}
