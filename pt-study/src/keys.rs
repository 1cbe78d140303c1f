//! The keys of a study file. The reader takes these and no others, and README.md shows them.

/// A key of a table.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// What its value may be.
    pub takes: &'static str,
    /// Value without it.
    pub default: DefaultValue,
    /// One sentence.
    pub meaning: &'static str,
}

/// What holds where a key is not given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DefaultValue {
    /// The key must be given.
    Required,
    /// A value, as TOML.
    Toml(&'static str),
    /// What no TOML value says.
    Words(&'static str),
}

use DefaultValue::{Required, Toml, Words};

const fn key(name: &'static str, takes: &'static str, default: DefaultValue, meaning: &'static str) -> Key {
    Key { name, takes, default, meaning }
}

/// Keys of the study itself.
pub const STUDY: &[Key] = &[
    key("name", "string", Words("name of the file"), "Name of the study."),
    key("question", "string", Toml("\"\""), "The question that the study answers, one sentence."),
    key("scenes", "strings", Required, "Built-in scenes by name, or glTF files beside the study file."),
    key(
        "cameras",
        "strings or numbers",
        Words("the scene's first"),
        "Cameras by name or index, `\"EX,EY,EZ,TX,TY,TZ\"` (eye and target), or `\"F.json\"`: the way of a camera that `pt view` has recorded.",
    ),
    key("sizes", "strings `\"WxH\"`", Toml("[\"640x360\"]"), "Sizes of the picture, pixels."),
    key(
        "backends",
        "strings",
        Toml("[\"auto\"]"),
        "Trace backends: `auto`, `compute`, `ray-query`, `rt-pipeline`, `rt-reorder`.",
    ),
    key("seeds", "whole number, or a list of them", Toml("5"), "Seeds, or how many, counted from 0."),
    key("frames", "whole number above 0", Toml("16"), "Frames that each cell renders."),
    key(
        "measure",
        "whole number above 0, or `\"A..B\"`",
        Toml("1"),
        "How many of the last frames are measured, or the frames A to B - 1.",
    ),
    key(
        "measure_at",
        "`\"radiance\"`, `\"display\"`",
        Toml("\"radiance\""),
        "Which picture is measured: radiance before bloom and exposure, or the picture as shown, in linear display values.",
    ),
    key("time", "number, s", Toml("0.0"), "Scene time of the first frame."),
    key("fps", "number above 0", Toml("60.0"), "Frames per second of scene time."),
    key(
        "sky",
        "string `\"ELEVATION,AZIMUTH[,TURBIDITY[,ALBEDO]]\"`",
        Words("the scene's environment"),
        "Physical sky with its sun in place of the environment of all scenes, as `--sky` takes it.",
    ),
    key(
        "accumulate",
        "boolean",
        Toml("false"),
        "Whether the frames are averaged, with the scene held still.",
    ),
    key(
        "against",
        "`\"reference\"`, or a folder",
        Toml("\"reference\""),
        "Ground truth: path traced, or the references of a capture (`pt capture --reference-spp`), whose folder is relative to the study file.",
    ),
    key("spp", "whole number above 0", Toml("256"), "Samples per pixel of a reference that is path traced."),
    key(
        "metrics",
        "strings",
        Required,
        "`relmse`, `mse`, `flip`, `hdr-flip`, `ssim`, `energy`, `detail` of frames; `temporal_pixel`, `temporal_block` of changes from frame to frame.",
    ),
    key(
        "set",
        "table of knobs",
        Toml("{}"),
        "Knobs that all variants have, `reference.*` (knobs of the reference) and `profile`.",
    ),
    key("axis", "tables `[[axis]]`", Words("none"), "Axes whose values make the variants."),
    key("variant", "tables `[[variant]]`", Words("none"), "Named variants, an axis of their own."),
    key(
        "design",
        "`\"all\"`, `\"one-at-a-time\"`",
        Toml("\"all\""),
        "Which variants there are: all combinations, or the first values of all axes (`baseline`) and each other value alone.",
    ),
    key("baseline", "string", Words("the first variant"), "Variant that the others are compared with."),
    key(
        "pairing",
        "`\"independent\"`, `\"seed\"`",
        Toml("\"independent\""),
        "Whether each variant has random numbers of its own, or all have the same for the same seed.",
    ),
    key(
        "images",
        "`\"none\"`, `\"first-seed\"`, `\"all\"`",
        Toml("\"first-seed\""),
        "Of which cells pictures are kept.",
    ),
    key("ledger", "table `[ledger]`", Words("none"), "Splits the error over the stages of the frame."),
];

/// Keys of `[[axis]]`.
pub const AXIS: &[Key] = &[
    key(
        "key",
        "string",
        Words("none"),
        "The knob that the axis sets, or `profile`; without it the axis sets nothing and is a placebo.",
    ),
    key("name", "string", Words("the knob"), "Name of the axis; required without `key`."),
    key(
        "values",
        "list, or `\"all\"`",
        Required,
        "Values of the knob; `\"all\"`: every name that the knob takes.",
    ),
    key("except", "strings", Words("none"), "Names that `values = \"all\"` leaves out."),
];

/// Keys of `[[variant]]`.
pub const VARIANT: &[Key] = &[
    key("name", "string", Required, "Name of the variant."),
    key("set", "table of knobs", Toml("{}"), "Its knobs, which override the common `set`."),
];

/// Keys of `[ledger]`.
pub const LEDGER: &[Key] = &[
    key("metric", "string", Toml("\"relmse\""), "The metric that is split: an error of single frames."),
    key(
        "stages",
        "strings",
        Words("all"),
        "Stages that are fed with ground truth, in the order of the ledger whatever theirs is.",
    ),
];

/// The names of keys.
pub(crate) fn names(keys: &[Key]) -> Vec<&'static str> {
    keys.iter().map(|key| key.name).collect()
}
