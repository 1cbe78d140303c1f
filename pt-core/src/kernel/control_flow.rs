//! Control flow of a SPIR-V function: which blocks are reached when some conditions are known, and the function without the others.

use super::access::{OP_LABEL, OP_SELECTION_MERGE, encode};
use super::fold::Constants;
use std::collections::{HashMap, HashSet};

const OP_PHI: u32 = 245;
const OP_LOOP_MERGE: u32 = 246;
const OP_BRANCH: u32 = 249;
const OP_BRANCH_CONDITIONAL: u32 = 250;
const OP_SWITCH: u32 = 251;
const OP_UNREACHABLE: u32 = 255;
const OP_FUNCTION_END: u32 = 56;

type Instruction<'a> = (u32, &'a [u32]);

/// A basic block.
struct Block<'a> {
    label: u32,
    /// The last one is the terminator.
    body: Vec<Instruction<'a>>,
}

/// A function of a module.
pub(super) struct Function<'a> {
    /// The definition and its parameters.
    head: Vec<Instruction<'a>>,
    blocks: Vec<Block<'a>>,
}

/// What runs of a function.
struct Flow {
    reached: HashSet<u32>,
    /// From block to block.
    edges: HashSet<(u32, u32)>,
    /// Blocks whose terminator has one target.
    target: HashMap<u32, u32>,
}

impl<'a> Function<'a> {
    pub(super) fn new(op: u32, operands: &'a [u32]) -> Self {
        Self { head: vec![(op, operands)], blocks: Vec::new() }
    }

    pub(super) fn push(&mut self, op: u32, operands: &'a [u32]) {
        match (op, operands, self.blocks.last_mut()) {
            (OP_FUNCTION_END, ..) => {}
            (OP_LABEL, [label], _) => self.blocks.push(Block { label: *label, body: Vec::new() }),
            (_, _, Some(block)) => block.body.push((op, operands)),
            (_, _, None) => self.head.push((op, operands)),
        }
    }

    /// Result of the definition.
    pub(super) fn id(&self) -> u32 {
        self.head[0].1[1]
    }

    /// Its instructions without what the constants switch off.
    pub(super) fn folded(&self, constants: &Constants) -> Vec<Vec<u32>> {
        let flow = self.flow(constants);
        let (merges, continues) = self.kept_targets(&flow);
        let mut out: Vec<Vec<u32>> = self.head.iter().map(|&(op, w)| encode(op, w)).collect();
        for block in &self.blocks {
            let label = encode(OP_LABEL, &[block.label]);
            if flow.reached.contains(&block.label) {
                out.push(label);
                block.write(&flow, &mut out);
            } else if let Some(header) = continues.get(&block.label) {
                out.extend([label, encode(OP_BRANCH, &[*header])]);
            } else if merges.contains(&block.label) {
                out.extend([label, encode(OP_UNREACHABLE, &[])]);
            }
        }
        out.push(encode(OP_FUNCTION_END, &[]));
        out
    }

    /// Follows the blocks in their order: SPIR-V places a block after those that dominate it, so that only the back edges of loops lead
    /// to earlier blocks, and those are reached already.
    fn flow(&self, constants: &Constants) -> Flow {
        let mut constants = constants.clone();
        let mut flow = Flow { reached: HashSet::new(), edges: HashSet::new(), target: HashMap::new() };
        flow.reached.extend(self.blocks.first().map(|entry| entry.label));
        let mut visited = HashSet::new();
        for block in &self.blocks {
            visited.insert(block.label);
            if !flow.reached.contains(&block.label) {
                continue;
            }
            for &(op, w) in &block.body {
                let value = match w {
                    [_, _, pairs @ ..] if op == OP_PHI => {
                        let (ids, parents): (Vec<u32>, Vec<u32>) = pairs
                            .chunks_exact(2)
                            .filter(|p| !visited.contains(&p[1]) || flow.edges.contains(&(p[1], block.label)))
                            .map(|p| (p[0], p[1]))
                            .unzip();
                        let known = parents.iter().all(|parent| visited.contains(parent));
                        let mut values = ids.iter().map(|id| constants.values.get(id).copied());
                        let first = values.next().flatten();
                        first.filter(|_| known && values.all(|value| value == first))
                    }
                    [ty, _, operands @ ..] => constants.evaluate(op, *ty, operands),
                    _ => None,
                };
                if let (Some(value), [_, id, ..]) = (value, w) {
                    constants.values.insert(*id, value);
                }
            }
            let known = block.known_target(&constants.values);
            let targets = known.map_or_else(|| block.targets(), |target| vec![target]);
            flow.target.extend(known.map(|target| (block.label, target)));
            flow.edges.extend(targets.iter().map(|&target| (block.label, target)));
            flow.reached.extend(targets);
        }
        flow
    }

    /// Unreached blocks that merge instructions still name: merge blocks, and continue targets with their loops.
    fn kept_targets(&self, flow: &Flow) -> (HashSet<u32>, HashMap<u32, u32>) {
        let mut merges = HashSet::new();
        let mut continues = HashMap::new();
        for block in self.blocks.iter().filter(|block| flow.reached.contains(&block.label)) {
            match block.merge() {
                Some((OP_LOOP_MERGE, [merge, target, ..])) => {
                    merges.insert(*merge);
                    continues.insert(*target, block.label);
                }
                Some((OP_SELECTION_MERGE, [merge, ..])) if !block.drops_merge(flow) => {
                    merges.insert(*merge);
                }
                _ => {}
            }
        }
        (merges, continues)
    }
}

impl<'a> Block<'a> {
    fn terminator(&self) -> Instruction<'a> {
        self.body.last().copied().unwrap_or((OP_UNREACHABLE, &[]))
    }

    /// The merge instruction before the terminator.
    fn merge(&self) -> Option<Instruction<'a>> {
        let place = self.body.len().checked_sub(2)?;
        Some(self.body[place]).filter(|(op, _)| matches!(*op, OP_LOOP_MERGE | OP_SELECTION_MERGE))
    }

    /// Whether it is no selection any more. A switch stays one: nested blocks may leave it by a branch to its merge block, which they
    /// may not do with the merge block of an `if`.
    fn drops_merge(&self, flow: &Flow) -> bool {
        self.terminator().0 == OP_BRANCH_CONDITIONAL && flow.target.contains_key(&self.label)
    }

    fn targets(&self) -> Vec<u32> {
        match self.terminator() {
            (OP_BRANCH, [target]) => vec![*target],
            (OP_BRANCH_CONDITIONAL, [_, yes, no, ..]) => vec![*yes, *no],
            (OP_SWITCH, [_, default, cases @ ..]) => {
                std::iter::once(*default).chain(cases.chunks_exact(2).map(|case| case[1])).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Where a conditional terminator goes if its condition is known.
    fn known_target(&self, values: &HashMap<u32, u32>) -> Option<u32> {
        match self.terminator() {
            (OP_BRANCH_CONDITIONAL, [condition, yes, no, ..]) => {
                values.get(condition).map(|&value| if value != 0 { *yes } else { *no })
            }
            (OP_SWITCH, [selector, default, cases @ ..]) => {
                let value = values.get(selector)?;
                let case = cases.chunks_exact(2).find(|case| case[0] == *value);
                Some(case.map_or(*default, |case| case[1]))
            }
            _ => None,
        }
    }

    fn write(&self, flow: &Flow, out: &mut Vec<Vec<u32>>) {
        let last = self.body.len().saturating_sub(1);
        for (place, &(op, w)) in self.body.iter().enumerate() {
            let known = flow.target.get(&self.label).filter(|_| place == last);
            match (op, w, known) {
                (OP_PHI, [ty, id, pairs @ ..], _) => {
                    let kept = pairs.chunks_exact(2).filter(|p| flow.edges.contains(&(p[1], self.label)));
                    let operands: Vec<u32> = [*ty, *id].into_iter().chain(kept.flatten().copied()).collect();
                    out.push(encode(OP_PHI, &operands));
                }
                (OP_SELECTION_MERGE, ..) if self.drops_merge(flow) => {}
                (OP_BRANCH_CONDITIONAL, _, Some(target)) => out.push(encode(OP_BRANCH, &[*target])),
                (OP_SWITCH, [selector, ..], Some(target)) => {
                    out.push(encode(OP_SWITCH, &[*selector, *target]))
                }
                _ => out.push(encode(op, w)),
            }
        }
    }
}
