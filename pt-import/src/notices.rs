//! What the loader tells about a file: deviations that it lives with, and parts that it leaves out.

use std::collections::BTreeMap;

use pt_scene::one_line;

/// Notices in order of first appearance; the same remark about many places is one notice.
#[derive(Default)]
pub(crate) struct Notices {
    list: Vec<Notice>,
    /// From remark to its entry in `list`.
    known: BTreeMap<String, usize>,
}

struct Notice {
    first: String,
    others: usize,
    what: String,
}

/// A remark about a place, made where [`Notices`] cannot be reached.
pub(crate) type Remark = (String, String);

impl Notices {
    /// `what` is true of the JSON path `at`.
    pub fn add(&mut self, at: impl ToString, what: impl Into<String>) {
        let what = what.into();
        match self.known.get(&what) {
            Some(&i) => self.list[i].others += 1,
            None => {
                self.known.insert(what.clone(), self.list.len());
                self.list.push(Notice { first: at.to_string(), others: 0, what });
            }
        }
    }

    pub fn extend(&mut self, remarks: Vec<Remark>) {
        remarks.into_iter().for_each(|(at, what)| self.add(at, what));
    }

    /// One line each.
    pub fn into_lines(self) -> Vec<String> {
        let line = |n: Notice| match n.others {
            0 => one_line(&format!("{}: {}", n.first, n.what)),
            others => one_line(&format!("{} and {others} more: {}", n.first, n.what)),
        };
        self.list.into_iter().map(line).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_remarks_are_counted() {
        let mut notices = Notices::default();
        notices.add("a[0]", "odd");
        notices.add("b", "even");
        notices.add("a[1]", "odd");
        notices.add("a[2]", "odd");
        assert_eq!(notices.into_lines(), ["a[0] and 2 more: odd", "b: even"]);
    }
}
