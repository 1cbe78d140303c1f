//! Which images of a frame share memory: those whose content is needed one after the other.
//!
//! Time counts the stages of a frame in the order in which they run. An image that lives within a frame takes the place of another of the same
//! size whose time is over, or of last frame's content of one, which nothing reads from some stage on (interval partitioning: Kleinberg and Tardos,
//! Algorithm Design, section 4.1). Images that exist twice are partitioned by the times at which both of the two are needed.

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
    fn can_hold(&self, other: &Self) -> bool {
        self.extent == other.extent && self.format.bytes() == other.format.bytes()
    }
}

/// Bytes of the texels of an image.
pub(crate) fn image_bytes(extent: [u32; 2], format: Format) -> u64 {
    u64::from(extent[0]) * u64::from(extent[1]) * u64::from(format.bytes())
}

/// Memories that are used in turn. Images that exist twice, but need both only one after the other, share one spare memory: each writes this frame's content
/// where the one before it no longer needs last frame's, the first one into the spare. So in each frame everything is one memory further, and the next
/// frame finds the spare behind the last one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Ring {
    /// The wishes that have a memory here, in their order in time.
    pub(crate) wishes: Vec<usize>,
    /// Whether there is one memory more than wishes.
    pub(crate) has_spare: bool,
    /// Whether images of other formats use them.
    pub(crate) other_formats: bool,
}

impl Ring {
    /// How many memories it has.
    pub(crate) fn count(&self) -> usize {
        self.wishes.len() + usize::from(self.has_spare)
    }
}

/// Where an image is: in the memory `first` of a ring in the first frame, and one before it in each later frame. The last frame's content is in the one behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) ring: usize,
    pub(crate) first: usize,
}

/// Memory of a ring with the times of a frame at which it is taken.
struct Memory {
    place: Place,
    taken: Vec<[usize; 2]>,
}

/// Behind all stages.
pub(crate) const LAST: usize = usize::MAX;

/// The memory of a frame, and the place of each image in it.
pub(crate) fn lay_out(wishes: &[Wish]) -> (Vec<Ring>, Vec<Place>) {
    let (mut rings, mut places) = rings(wishes);
    let mut memories: Vec<Memory> = Vec::new();
    for (number, ring) in rings.iter().enumerate().filter(|(_, ring)| ring.has_spare) {
        let mut taken = vec![Vec::new(); ring.count()];
        for (turn, &wish) in ring.wishes.iter().enumerate() {
            if let Life::Twice { from, previous_until } = wishes[wish].life {
                taken[turn].push([from, LAST]);
                taken[turn + 1].push([0, previous_until]);
            }
        }
        let memory = |(first, taken)| Memory { place: Place { ring: number, first }, taken };
        memories.extend(taken.into_iter().enumerate().map(memory));
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
        let owner = |memory: &Memory| &wishes[rings[memory.place.ring].wishes[0]];
        let is_free = |memory: &&mut Memory| {
            let apart = |taken: &[usize; 2]| taken[1] < time[0] || time[1] < taken[0];
            owner(memory).can_hold(wish) && memory.taken.iter().all(apart)
        };
        // Views of another format are the second choice.
        let differs = |memory: &&mut Memory| owner(memory).format != wish.format;
        match memories.iter_mut().filter(is_free).min_by_key(differs) {
            Some(memory) => {
                memory.taken.push(time);
                places[number] = memory.place;
                let ring = &mut rings[memory.place.ring];
                ring.other_formats |= wishes[ring.wishes[0]].format != wish.format;
            }
            None => {
                places[number] = Place { ring: rings.len(), first: 0 };
                rings.push(Ring { wishes: vec![number], has_spare: false, other_formats: false });
                memories.push(Memory { place: places[number], taken: vec![time] });
            }
        }
    }
    (rings, places)
}

/// The rings of the images that outlive a frame, with their places; other images have none yet.
fn rings(wishes: &[Wish]) -> (Vec<Ring>, Vec<Place>) {
    let mut rings: Vec<Ring> = Vec::new();
    let mut places = vec![Place { ring: 0, first: 0 }; wishes.len()];
    let mut twice: Vec<(usize, usize)> = Vec::new();
    for (number, wish) in wishes.iter().enumerate() {
        match wish.life {
            Life::Twice { from, .. } => twice.push((from, number)),
            Life::Always | Life::Kept => {
                places[number].ring = rings.len();
                rings.push(Ring { wishes: vec![number], has_spare: false, other_formats: false });
            }
            Life::Within { .. } => {}
        }
    }
    twice.sort_unstable();
    for (from, number) in twice {
        let wish = &wishes[number];
        let last = |ring: &Ring| ring.wishes.last().map(|&last| wishes[last]);
        let is_free = |ring: &&mut Ring| {
            last(ring).is_some_and(|last| match last.life {
                Life::Twice { previous_until, .. } => previous_until < from && last.can_hold(wish),
                _ => false,
            })
        };
        let differs = |ring: &&mut Ring| wishes[ring.wishes[0]].format != wish.format;
        let found = rings.iter_mut().enumerate().filter(|(_, ring)| is_free(ring));
        match found.min_by_key(|(_, ring)| differs(ring)) {
            Some((at, ring)) => {
                places[number] = Place { ring: at, first: ring.wishes.len() };
                ring.other_formats |= wishes[ring.wishes[0]].format != wish.format;
                ring.wishes.push(number);
            }
            None => {
                places[number].ring = rings.len();
                rings.push(Ring { wishes: vec![number], has_spare: true, other_formats: false });
            }
        }
    }
    (rings, places)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wish(format: Format, life: Life) -> Wish {
        Wish { extent: [8, 4], format, life }
    }

    fn within(from: usize, until: usize) -> Life {
        Life::Within { from, until }
    }

    fn at(ring: usize, first: usize) -> Place {
        Place { ring, first }
    }

    fn places(wishes: &[Wish]) -> Vec<Place> {
        lay_out(wishes).1
    }

    /// How many memories there are.
    fn count(wishes: &[Wish]) -> usize {
        lay_out(wishes).0.iter().map(Ring::count).sum()
    }

    #[test]
    fn images_that_follow_each_other_share_and_those_that_meet_do_not() {
        let color = |life| wish(Format::Rgba32F, life);
        assert_eq!(places(&[color(within(0, 2)), color(within(3, 4))]), [at(0, 0), at(0, 0)]);
        // A stage reads the one and writes the other.
        assert_eq!(places(&[color(within(0, 3)), color(within(3, 4))]), [at(0, 0), at(1, 0)]);
        assert_eq!(places(&[color(Life::Always), color(within(3, 4))]), [at(0, 0), at(1, 0)]);
        // The last one may take either place; all three at once need three.
        let four = [within(0, 1), within(0, 5), within(2, 5), within(2, 3)].map(color);
        assert_eq!(places(&four), [at(0, 0), at(1, 0), at(0, 0), at(2, 0)]);
        assert_eq!(places(&[color(within(0, LAST)), color(within(3, LAST))]), [at(0, 0), at(1, 0)]);
    }

    #[test]
    fn histories_have_room_before_they_are_written_and_after_they_were_read() {
        let color = |life| wish(Format::Rgba32F, life);
        let history = color(Life::Twice { from: 2, previous_until: 2 });
        assert_eq!(places(&[history, color(within(2, 3))]), [at(0, 0), at(1, 0)]);
        let before = color(within(0, 1));
        let after = color(within(3, LAST));
        assert_eq!(places(&[after, history, before]), [at(0, 1), at(0, 0), at(0, 0)]);
        // One that is needed before and after.
        assert_eq!(places(&[history, color(within(1, 3))]), [at(0, 0), at(1, 0)]);
    }

    #[test]
    fn histories_that_are_written_one_after_the_other_share_a_spare() {
        let twice = |from, previous_until| wish(Format::Rgba32F, Life::Twice { from, previous_until });
        let turns = [twice(0, 1), twice(2, 3), twice(4, 5)];
        assert_eq!(places(&turns), [at(0, 0), at(0, 1), at(0, 2)]);
        assert_eq!(count(&turns), 4);
        assert_eq!(places(&[turns[2], turns[0]]), [at(0, 1), at(0, 0)], "the order is that in time");
        assert_eq!(count(&[twice(0, 2), twice(2, 3)]), 4, "a stage needs all four");
        assert_eq!(count(&[twice(0, LAST), twice(0, LAST)]), 4);
        assert_eq!(count(&[twice(0, 1), Wish { extent: [4, 4], ..twice(2, 3) }]), 4);
        // Between the two, and not while one of them is there twice.
        let color = |from, until| wish(Format::Rgba32F, within(from, until));
        assert_eq!(places(&[twice(1, 2), twice(5, 6), color(3, 4)])[2], at(0, 1));
        assert_eq!(count(&[twice(1, 2), twice(5, 6), color(2, 4)]), 4);
        assert_eq!(count(&[twice(1, 2), twice(5, 6), color(3, 5)]), 4);
    }

    /// Runs frames of random wishes: what an image holds is there until nobody needs it.
    #[test]
    fn no_content_is_overwritten_before_it_is_read() {
        let mut state = 1_u32;
        let mut random = |below: usize| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16) as usize % below
        };
        for _ in 0..200 {
            let wishes: Vec<Wish> = (0..1 + random(12))
                .map(|_| {
                    let (a, b) = (random(10), random(10));
                    let life = match random(3) {
                        0 => Life::Twice { from: a.min(b), previous_until: a.max(b) },
                        _ => within(a.min(b), a.max(b)),
                    };
                    wish([Format::Rgba32F, Format::Rgba32Uint][random(2)], life)
                })
                .collect();
            let (rings, places) = lay_out(&wishes);
            let memory = |number: usize, frame: usize| {
                let Place { ring, first } = places[number];
                let count = rings[ring].count();
                (ring, (first + count * 8 - frame) % count)
            };
            // Who wrote a memory last, and in which frame.
            let mut content = std::collections::BTreeMap::new();
            for (frame, now) in (0..7).flat_map(|frame| (0..10).map(move |now| (frame, now))) {
                for (number, wish) in wishes.iter().enumerate() {
                    if matches!(wish.life, Life::Twice { from, .. } | Life::Within { from, .. } if from == now)
                    {
                        content.insert(memory(number, frame), (number, frame));
                    }
                }
                for (number, wish) in wishes.iter().enumerate() {
                    let holds = |of: usize| content.get(&memory(number, of)) == Some(&(number, of));
                    let ok = match wish.life {
                        Life::Twice { from, previous_until } => {
                            (now < from || holds(frame))
                                && (frame == 0 || now > previous_until || holds(frame - 1))
                        }
                        Life::Within { from, until } => !(from..=until).contains(&now) || holds(frame),
                        Life::Always | Life::Kept => true,
                    };
                    assert!(
                        ok,
                        "wish {number} of {wishes:?} in frame {frame} at {now}: {rings:?}, {places:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn only_images_of_one_size_share() {
        let small = Wish { extent: [4, 4], ..wish(Format::Rgba32F, within(2, 3)) };
        assert_eq!(count(&[wish(Format::Rgba32F, within(0, 1)), small]), 2);
        let half = wish(Format::Rgba16F, within(2, 3));
        assert_eq!(count(&[wish(Format::Rgba32F, within(0, 1)), half]), 2);
        let (rings, places) = lay_out(&[wish(Format::Rg32Uint, within(0, 1)), half]);
        assert!(rings.len() == 1 && rings[0].other_formats);
        assert_eq!(places, [at(0, 0), at(0, 0)]);
        let three = [wish(Format::Rg32Uint, within(0, 1)), wish(Format::Rgba16F, within(0, 1)), half];
        let (rings, places) = lay_out(&three);
        assert_eq!(places, [at(0, 0), at(1, 0), at(1, 0)], "the same format first");
        assert!(rings.iter().all(|ring| !ring.other_formats));
    }
}
