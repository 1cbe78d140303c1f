//! Flags that stand for knobs. The values that a flag accepts, its help and its default come from the declaration of the knob.

use super::values::one_of;
use clap::builder::ValueParser;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, Error, FromArgMatches};
use pt_core::settings::Knob;
use pt_shaders::KnobKind;
use std::marker::PhantomData;

/// A flag that stands for a knob, or for a table of boolean knobs: it then takes the list of those that are true.
#[derive(Clone, Copy)]
pub struct Flag {
    /// Without the dashes.
    pub name: &'static str,
    /// Key of the knob or of the table.
    pub key: &'static str,
    /// Placeholder of the value in the help.
    pub value_name: &'static str,
    /// Value if none is given; `None`: a value is required. Flags of boolean knobs take no value.
    pub without_value: Option<&'static str>,
    /// Other names of values: returns the value for a name.
    pub aliases: fn(&str) -> Option<String>,
    /// Other assignments that the flag makes unless another flag does: for which value (empty: any), which assignment.
    pub implies: &'static [(&'static str, &'static str)],
    /// Text in the help after the knob's own sentence; for a table, the name of the list.
    pub note: &'static str,
}

impl Flag {
    /// A flag that stands for a knob and nothing else.
    pub const fn new(name: &'static str, key: &'static str, value_name: &'static str) -> Self {
        Self { name, key, value_name, without_value: None, aliases: |_| None, implies: &[], note: "" }
    }

    fn arg(&self, knobs: &[Knob], heading: &'static str) -> Arg {
        let arg = Arg::new(self.name).long(self.name).help_heading(heading);
        let Some(knob) = knobs.iter().find(|knob| knob.key == self.key) else {
            return self.list_arg(arg, knobs);
        };
        let help = knob.doc.trim_end_matches('.');
        if knob.kind == KnobKind::Boolean {
            return arg.help(help.to_owned()).action(ArgAction::SetTrue);
        }
        let (takes, parser) = match knob.kind {
            KnobKind::Enum => (String::new(), ValueParser::new(one_of(knob.values))),
            _ => {
                let (knob, aliases) = (knob.clone(), self.aliases);
                let takes = format!(" ({})", knob.takes());
                let parser = move |text: &str| match aliases(text) {
                    Some(value) => Ok(value),
                    None => knob.check(text).map(|()| text.to_owned()),
                };
                (takes, ValueParser::new(parser))
            }
        };
        let arg = arg
            .help(format!("{help}{takes}{} [default: {}]", self.note, knob.default_text()))
            .value_name(self.value_name)
            .value_parser(parser)
            .allow_hyphen_values(knob.kind == KnobKind::Number);
        match self.without_value {
            Some(value) => arg.num_args(0..=1).require_equals(true).default_missing_value(value),
            None => arg,
        }
    }

    fn list_arg(&self, arg: Arg, knobs: &[Knob]) -> Arg {
        let names: Vec<String> = members(knobs, self.key).map(str::to_owned).collect();
        let help = format!("{}: any of {} [default: all]", self.note, names.join(", "));
        let parser = move |text: &str| {
            let known = names.iter().any(|name| name == text);
            if known { Ok(text.to_owned()) } else { Err(format!("expected any of {}", names.join(", "))) }
        };
        let arg = arg.help(help).value_name(self.value_name).value_delimiter(',');
        arg.value_parser(parser).action(ArgAction::Append)
    }

    /// The flag as assignments, implied ones first; empty if it is not given.
    fn assignments(&self, knobs: &[Knob], matches: &ArgMatches) -> [Vec<String>; 2] {
        let Some(knob) = knobs.iter().find(|knob| knob.key == self.key) else {
            let Some(on) = matches.get_many::<String>(self.name) else { return Default::default() };
            let on: Vec<_> = on.collect();
            let set = |name: &str| format!("{}.{name}={}", self.key, on.iter().any(|on| *on == name));
            return [Vec::new(), members(knobs, self.key).map(set).collect()];
        };
        let value = match knob.kind {
            KnobKind::Boolean => matches.get_flag(self.name).then(|| "true".to_owned()),
            _ => matches.get_one::<String>(self.name).cloned(),
        };
        let Some(value) = value else { return Default::default() };
        let implied = self.implies.iter().filter(|(with, _)| with.is_empty() || *with == value);
        [
            implied.map(|(_, assignment)| (*assignment).to_owned()).collect(),
            vec![format!("{}={value}", self.key)],
        ]
    }
}

/// Names of the knobs in a table.
fn members<'a>(knobs: &'a [Knob], table: &'a str) -> impl Iterator<Item = &'a str> {
    knobs.iter().filter_map(move |knob| knob.key.strip_prefix(table)?.strip_prefix('.'))
}

/// A set of flags under one heading.
pub trait FlagSet {
    /// Heading in the help.
    const HEADING: &'static str;
    /// The flags.
    const FLAGS: &'static [Flag];
    /// The knobs that they are short for, among others.
    fn knobs() -> Vec<Knob>;
}

/// The flags of `S` on a command line.
pub struct Flags<S> {
    /// As assignments for `--set`.
    pub sets: Vec<String>,
    flags: PhantomData<S>,
}

impl<S> Clone for Flags<S> {
    fn clone(&self) -> Self {
        Self { sets: self.sets.clone(), flags: PhantomData }
    }
}

impl<S> std::fmt::Debug for Flags<S> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.sets.fmt(f)
    }
}

impl<S: FlagSet> Args for Flags<S> {
    fn augment_args(command: Command) -> Command {
        let knobs = S::knobs();
        command.args(S::FLAGS.iter().map(|flag| flag.arg(&knobs, S::HEADING)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<S: FlagSet> FromArgMatches for Flags<S> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let knobs = S::knobs();
        let [implied, said] = S::FLAGS.iter().map(|flag| flag.assignments(&knobs, matches)).fold(
            [Vec::new(), Vec::new()],
            |[mut implied, mut said], [also, says]| {
                implied.extend(also);
                said.extend(says);
                [implied, said]
            },
        );
        Ok(Self { sets: [implied, said].concat(), flags: PhantomData })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
