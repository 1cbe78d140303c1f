//! Where images and tables of a frame are in its memory: those whose content is needed one after the other share it.
//!
//! Time counts the stages of a frame in the order in which they run. What lives within a frame takes the place of what nobody needs any more or yet,
//! also of several smaller ones or of a part of a larger one: it is placed by size, the largest first, where it fits at the lowest offset (dynamic storage allocation by
//! first fit in decreasing order: Coffman, Garey, Johnson and Tarjan 1980). Images that exist twice are partitioned before by the times at which both of the two are needed
//! (interval partitioning: Kleinberg and Tardos, Algorithm Design, section 4.1).

/// From when to when a content is needed.
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

/// What a frame needs memory for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wish {
    /// A multiple of what offsets must be multiples of.
    pub(crate) bytes: u64,
    /// Types of memory that it may be in, a bit each.
    pub(crate) types: u32,
    pub(crate) life: Life,
}

/// A piece of memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Block {
    pub(crate) bytes: u64,
    pub(crate) types: u32,
    /// The wish that has it in the first frame, if it is an image that outlives a frame; the spare one has none.
    pub(crate) owner: Option<usize>,
}

/// Where something is: at the offset in the block `turns[first]` in the first frame, and one before it in each later frame. Last frame's content is in the one behind it.
///
/// Images that exist twice, but need both only one after the other, share one spare block: each writes this frame's content where the one before it no
/// longer needs last frame's, the first one into the spare. So in each frame everything is one block further, and the next frame finds the spare behind the last one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) turns: Vec<usize>,
    pub(crate) first: usize,
    pub(crate) offset: u64,
}

/// Bytes of a block and times of a frame at which they are taken.
#[derive(Clone, Copy, Debug)]
struct Taken {
    time: [usize; 2],
    bytes: [u64; 2],
}

/// A block with what is in it. The number of its ring, and its place there.
struct Space {
    taken: Vec<Taken>,
    ring: Option<(usize, usize)>,
}

/// Behind all stages.
pub(crate) const LAST: usize = usize::MAX;

/// The blocks of a frame, and the place of each wish in them. No block but for a wish of its own is larger than `largest` bytes.
pub(crate) fn lay_out(wishes: &[Wish], largest: u64) -> (Vec<Block>, Vec<Place>) {
    let rings = rings(wishes);
    let mut blocks = Vec::new();
    let mut spaces: Vec<Space> = Vec::new();
    let mut places = vec![Place { turns: Vec::new(), first: 0, offset: 0 }; wishes.len()];
    let mut turns = Vec::new();
    for (number, ring) in rings.iter().enumerate() {
        let Wish { bytes, .. } = wishes[ring[0]];
        let types = ring.iter().fold(u32::MAX, |types, &wish| types & wishes[wish].types);
        let has_spare = matches!(wishes[ring[0]].life, Life::Twice { .. });
        let first_block = blocks.len();
        let mut taken = vec![Vec::new(); ring.len() + usize::from(has_spare)];
        for (turn, &wish) in ring.iter().enumerate() {
            blocks.push(Block { bytes, types, owner: Some(wish) });
            let mut take = |turn: usize, time| taken[turn].push(Taken { time, bytes: [0, bytes] });
            if let Life::Twice { from, previous_until } = wishes[wish].life {
                take(turn, [from, LAST]);
                take(turn + 1, [0, previous_until]);
            } else {
                take(turn, [0, LAST]);
            }
            places[wish].first = turn;
        }
        blocks.extend(has_spare.then_some(Block { bytes, types, owner: None }));
        let space = |(turn, taken)| Space { taken, ring: Some((number, turn)) };
        spaces.extend(taken.into_iter().enumerate().map(space));
        turns.push((first_block..blocks.len()).collect::<Vec<_>>());
        ring.iter().for_each(|&wish| places[wish].turns.clone_from(&turns[number]));
    }
    let outlive = blocks.len();
    for (number, time) in within(wishes) {
        let Wish { bytes, types, .. } = wishes[number];
        let room = |at: usize| if at < outlive { blocks[at].bytes } else { largest.max(bytes) };
        let fits = |at: usize| {
            let offset = free_offset(&spaces[at].taken, time, bytes);
            (blocks[at].types & types != 0 && offset + bytes <= room(at)).then_some((at, offset))
        };
        // The smallest block of those that are there anyway.
        let best = (0..outlive).filter_map(fits).min_by_key(|&(at, _)| blocks[at].bytes);
        let found = best.or_else(|| (outlive..blocks.len()).find_map(fits));
        let (at, offset) = found.unwrap_or_else(|| {
            blocks.push(Block { bytes: 0, types, owner: None });
            spaces.push(Space { taken: Vec::new(), ring: None });
            (blocks.len() - 1, 0)
        });
        spaces[at].taken.push(Taken { time, bytes: [offset, offset + bytes] });
        blocks[at].bytes = blocks[at].bytes.max(offset + bytes);
        places[number] = match spaces[at].ring {
            Some((ring, first)) => {
                turns[ring].iter().for_each(|&block| blocks[block].types &= types);
                Place { turns: turns[ring].clone(), first, offset }
            }
            None => {
                blocks[at].types &= types;
                Place { turns: vec![at], first: 0, offset }
            }
        };
    }
    (blocks, places)
}

/// What lives within a frame, the largest first.
fn within(wishes: &[Wish]) -> Vec<(usize, [usize; 2])> {
    let mut within: Vec<_> = (wishes.iter().enumerate())
        .filter_map(|(number, wish)| match wish.life {
            Life::Within { from, until } => Some((number, [from, until])),
            _ => None,
        })
        .collect();
    within.sort_by_key(|&(number, [from, _])| (std::cmp::Reverse(wishes[number].bytes), from, number));
    within
}

/// The lowest offset at which that many bytes are free at that time.
fn free_offset(taken: &[Taken], time: [usize; 2], bytes: u64) -> u64 {
    let meets = |other: &&Taken| other.time[0] <= time[1] && time[0] <= other.time[1];
    let mut ranges: Vec<_> = taken.iter().filter(meets).map(|taken| taken.bytes).collect();
    ranges.sort_unstable();
    let mut offset = 0;
    for [start, end] in ranges {
        if offset + bytes <= start {
            break;
        }
        offset = end.max(offset);
    }
    offset
}

/// The wishes that outlive a frame, those that share a spare block together, in their order in time.
fn rings(wishes: &[Wish]) -> Vec<Vec<usize>> {
    let mut rings: Vec<Vec<usize>> = Vec::new();
    let mut twice: Vec<(usize, usize)> = Vec::new();
    for (number, wish) in wishes.iter().enumerate() {
        match wish.life {
            Life::Twice { from, .. } => twice.push((from, number)),
            Life::Always | Life::Kept => rings.push(vec![number]),
            Life::Within { .. } => {}
        }
    }
    twice.sort_unstable();
    for (from, number) in twice {
        let wish = &wishes[number];
        let is_free = |ring: &&mut Vec<usize>| {
            ring.last().map(|&last| &wishes[last]).is_some_and(|last| match last.life {
                Life::Twice { previous_until, .. } => previous_until < from && last.bytes == wish.bytes,
                _ => false,
            })
        };
        match rings.iter_mut().find(is_free) {
            Some(ring) => ring.push(number),
            None => rings.push(vec![number]),
        }
    }
    rings
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wish(bytes: u64, life: Life) -> Wish {
        Wish { bytes, types: 1, life }
    }

    fn within(from: usize, until: usize) -> Life {
        Life::Within { from, until }
    }

    fn twice(from: usize, previous_until: usize) -> Life {
        Life::Twice { from, previous_until }
    }

    /// Bytes of all blocks.
    fn total(wishes: &[Wish]) -> u64 {
        lay_out(wishes, u64::MAX).0.iter().map(|block| block.bytes).sum()
    }

    fn all(bytes: u64, lives: &[Life]) -> u64 {
        total(&lives.iter().map(|&life| wish(bytes, life)).collect::<Vec<_>>())
    }

    #[test]
    fn what_follows_each_other_shares_and_what_meets_does_not() {
        assert_eq!(all(4, &[within(0, 2), within(3, 4)]), 4);
        assert_eq!(all(4, &[within(0, 3), within(3, 4)]), 8, "a stage reads the one and writes the other");
        assert_eq!(all(4, &[Life::Always, within(3, 4)]), 8);
        assert_eq!(all(4, &[within(0, LAST), within(3, LAST)]), 8);
        assert_eq!(total(&[wish(4, within(0, 1)), wish(2, within(2, 3)), wish(2, within(2, 3))]), 4);
        assert_eq!(total(&[wish(4, within(2, 3)), wish(2, within(0, 1)), wish(2, within(1, 1))]), 4);
        let other_type = Wish { types: 2, ..wish(4, within(2, 3)) };
        assert_eq!(total(&[wish(4, within(0, 1)), other_type]), 8);
    }

    #[test]
    fn blocks_are_not_too_large() {
        let three = [wish(4, within(0, 1)); 3];
        let sizes = |largest| lay_out(&three, largest).0.iter().map(|block| block.bytes).collect::<Vec<_>>();
        assert_eq!(sizes(12), [12]);
        assert_eq!(sizes(11), [8, 4]);
        assert_eq!(sizes(3), [4, 4, 4]);
    }

    #[test]
    fn histories_have_room_before_they_are_written_and_after_they_were_read() {
        let history = twice(2, 2);
        assert_eq!(all(4, &[history, within(2, 3)]), 12);
        assert_eq!(all(4, &[within(3, LAST), history, within(0, 1)]), 8);
        assert_eq!(all(4, &[history, within(1, 3)]), 12, "it is needed before and after");
        let places = lay_out(&[wish(4, history), wish(2, within(0, 1)), wish(2, within(0, 1))], 0).1;
        assert_eq!(places[1], Place { turns: vec![0, 1], first: 0, offset: 0 });
        assert_eq!(places[2], Place { turns: vec![0, 1], first: 0, offset: 2 });
    }

    #[test]
    fn histories_that_are_written_one_after_the_other_share_a_spare() {
        let turns = [twice(0, 1), twice(2, 3), twice(4, 5)];
        assert_eq!(all(4, &turns), 16);
        assert_eq!(all(4, &[twice(0, 2), twice(2, 3)]), 16, "a stage needs all four");
        assert_eq!(all(4, &[twice(0, LAST), twice(0, LAST)]), 16);
        assert_eq!(total(&[wish(4, twice(0, 1)), wish(2, twice(2, 3))]), 12);
        let order = lay_out(&[wish(4, turns[2]), wish(4, turns[0])], 0).1;
        assert_eq!([order[0].first, order[1].first], [1, 0], "the order is that in time");
        // Between the two, and not while one of them is there twice.
        assert_eq!(all(4, &[twice(1, 2), twice(5, 6), within(3, 4)]), 12);
        assert_eq!(all(4, &[twice(1, 2), twice(5, 6), within(2, 4)]), 16);
        assert_eq!(all(4, &[twice(1, 2), twice(5, 6), within(3, 5)]), 16);
    }

    /// Runs frames of random wishes: what something holds is there until nobody needs it.
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
                        0 => twice(a.min(b), a.max(b)),
                        _ => within(a.min(b), a.max(b)),
                    };
                    wish([1, 2, 4, 5][random(4)], life)
                })
                .collect();
            let (blocks, places) = lay_out(&wishes, 9);
            let bytes = |number: usize, frame: usize| {
                let Place { turns, first, offset } = &places[number];
                let block = turns[(first + turns.len() * 8 - frame) % turns.len()];
                let end = offset + wishes[number].bytes;
                assert!(end <= blocks[block].bytes);
                (*offset..end).map(move |byte| (block, byte))
            };
            // Who wrote a byte last, and in which frame.
            let mut content = std::collections::BTreeMap::new();
            for (frame, now) in (0..7).flat_map(|frame| (0..10).map(move |now| (frame, now))) {
                for (number, wish) in wishes.iter().enumerate() {
                    if matches!(wish.life, Life::Twice { from, .. } | Life::Within { from, .. } if from == now)
                    {
                        content.extend(bytes(number, frame).map(|byte| (byte, (number, frame))));
                    }
                }
                for (number, wish) in wishes.iter().enumerate() {
                    let holds =
                        |of: usize| bytes(number, of).all(|byte| content.get(&byte) == Some(&(number, of)));
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
                        "wish {number} of {wishes:?} in frame {frame} at {now}: {blocks:?}, {places:?}"
                    );
                }
            }
        }
    }
}
