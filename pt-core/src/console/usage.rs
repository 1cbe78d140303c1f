//! Messages about wrong command lines: what is wrong, and which option or command was probably meant.

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command, Error};
use std::path::Path;

/// Names of options that stand for one thing: those that some command has, and those that other programs have for it.
const OPTIONS: &[&[&str]] = &[
    &[
        "frames",
        "spp",
        "samples",
        "sample-count",
        "samples-per-pixel",
        "num-samples",
        "frame-count",
        "iterations",
    ],
    &["size", "width", "height", "resolution", "res", "dimensions", "image-size"],
    &["output", "out", "outfile", "output-file", "output-dir", "save", "o"],
    &["scene", "input", "file", "model", "gltf", "stats"],
    &["max-bounces", "bounces", "num-bounces", "max-depth", "depth", "path-length", "max-path-length"],
    &["device", "gpu", "adapter", "gpu-index"],
    &["backend", "trace-backend", "renderer", "accel"],
    &["env", "environment", "envmap", "env-map", "hdri", "hdr", "sky", "skybox", "ibl"],
    &["env-intensity", "env-scale", "env-strength", "env-exposure", "sky-intensity"],
    &["env-rotation", "env-rotate", "env-angle", "sky-rotation"],
    &["vfov", "fov", "fovy", "yfov", "field-of-view"],
    &["look", "look-at", "lookat", "eye", "target", "origin", "position", "camera-position"],
    &["tonemap", "tone-map", "tonemapper", "tone-mapping", "tonemapping", "curve"],
    &["ev", "ev100", "exposure-value"],
    &["seed", "random-seed", "rng-seed"],
    &["accumulate", "accumulation", "average", "mean"],
    &["time-limit", "timeout", "max-time", "seconds", "duration"],
    &["metric", "metrics", "measure", "error"],
    &["heatmap", "heat-map", "diff", "difference", "error-map"],
    &["region", "crop", "rect", "roi", "viewport"],
    &["set", "knob", "param", "option", "define"],
    &["profile", "preset", "config", "settings"],
    &["aov", "aovs", "channels", "layers", "buffers"],
    &["timings", "timing", "times", "stats-file"],
    &["fps", "framerate", "frame-rate"],
    &["time", "start", "start-time", "at"],
    &["upscale", "upscaler", "upscaling", "fsr", "taau"],
    &["render-scale", "scale", "resolution-scale"],
    &["background", "alpha", "transparent", "film-transparent"],
    &["clamp", "max-radiance", "clamp-indirect", "firefly-clamp"],
    &["tile", "tile-size", "tiles"],
    &["windows", "runs", "repeat", "repetitions"],
    &["validation", "validate", "validation-layers", "debug-layers"],
];

/// Options of other programs that are knobs here: the first name of their group, or a name of their own; the knob; a value, if the word
/// is one by itself. They are for commands whose --set takes the knobs of the frame.
const KNOBS: &[(&[&str], &str, Option<&str>)] = &[
    (&["denoise", "denoiser", "denoising"], "denoise.variant", None),
    (&["sampler", "light-sampler"], "lights.sampler", None),
    (&["max-bounces"], "indirect.bounces", None),
    (&["taa", "anti-aliasing", "antialiasing"], "post.taa.enabled", Some("true")),
    (&["checkerboard"], "checkerboard", None),
    (&["gbuffer"], "gbuffer", None),
    (&["lights"], "lights", None),
    (&["indirect", "gi"], "indirect", None),
    (&["post"], "post", None),
];

/// How --set is written where it takes the knobs of the frame.
const SETS_KNOBS: &str = "stage.key=value";

/// What a command has in another place than its options: the command, the first name of the group, and the place.
const PLACES: &[(&str, &str, &str)] = &[
    ("study", "set", "knobs stand in the study file: set = {KEY = VALUE}"),
    ("study", "profile", "it stands in the study file: set = {profile = \"NAME\"}"),
    ("study", "size", "sizes stand in the study file: sizes = [\"640x360\"]"),
    ("study", "seed", "seeds stand in the study file: seeds = 3"),
    ("replay", "size", "frames of a capture have its size"),
    ("replay", "profile", "the capture holds all knobs; --set changes one"),
    ("replay", "backend", "a replay traces no rays"),
    ("reference", "accumulate", "the mean of all samples is what it writes"),
    ("reference", "aov", "its EXR always has albedo, normal, depth, motion and coverage"),
];

/// Values of an option that belong to another one: the option, the values, what to use.
const VALUES: &[(&str, &[&str], &str)] = &[(
    "backend",
    &["cpu", "gpu", "llvmpipe", "lavapipe", "software", "cuda"],
    "--backend says how rays are traced; the CPU or a GPU is chosen by --device, for example --device llvmpipe (pt info lists them)",
)];

/// Names of commands that stand for one thing.
const COMMANDS: &[&[&str]] = &[
    &["render", "draw", "view", "show", "run", "rasterize"],
    &["reference", "trace", "pathtrace", "path-trace", "ground-truth", "gt"],
    &["compare", "diff", "metrics", "flip", "psnr"],
    &["info", "devices", "device", "gpus", "gpu", "version"],
    &["scenes", "scene", "list", "ls", "stats"],
    &["bench", "benchmark", "perf"],
    &["knobs", "params", "settings", "options"],
];

/// What the standard library says about numbers, and what it means to a user.
const NUMBERS: &[(&str, &str)] = &[
    ("invalid digit found in string", "expected a whole number of 0 or more"),
    ("cannot parse integer from empty string", "expected a whole number of 0 or more"),
    ("number too large to fit in target type", "the number is too large"),
    ("invalid float literal", "expected a number"),
    ("cannot parse float from empty string", "expected a number"),
];

/// The error as one line. `words`: the command line with the program's name.
pub(super) fn message(error: &Error, root: &Command, words: &[String]) -> String {
    let (path, command) = command_of(root, words);
    if error.kind() == ErrorKind::MissingRequiredArgument
        && let Some(ContextValue::Strings(missing)) = error.get(ContextKind::InvalidArg)
    {
        let missing: Vec<_> = missing.iter().map(|text| described(text, command)).collect();
        let who = asking(root, words).unwrap_or_else(|| path.clone());
        return format!("{who} needs {} (see {path} --help)", missing.join(", and "));
    }
    let found = match (error.kind(), invalid(error, ContextKind::InvalidArg)) {
        (ErrorKind::UnknownArgument, Some(word)) => unknown_argument(&word, root, &path, command, words),
        (ErrorKind::InvalidValue, Some(arg)) => {
            invalid(error, ContextKind::InvalidValue).and_then(|value| wrong_value(&arg, &value))
        }
        _ => None,
    };
    let found = found.or_else(|| {
        let word = invalid(error, ContextKind::InvalidSubcommand)?;
        unknown_command(error, &word, &path, command)
    });
    let message = found.unwrap_or_else(|| flat(&error.render().to_string()));
    format!("{message} (see {path} --help)")
}

fn invalid(error: &Error, kind: ContextKind) -> Option<String> {
    match error.get(kind)? {
        ContextValue::String(text) => Some(text.clone()),
        _ => None,
    }
}

/// The option without which nothing would be missing: what it needs is not there.
fn asking(root: &Command, words: &[String]) -> Option<String> {
    let command = command_of(root, words).1;
    let is_cause = |at: &usize| {
        let Some(arg) = words[*at].strip_prefix("--").and_then(|_| option(command, name_of(&words[*at])))
        else {
            return false;
        };
        let own = 1 + usize::from(arg.get_action().takes_values() && !words[*at].contains('='));
        let others = words[..*at].iter().chain(words.iter().skip(*at + own));
        root.clone().try_get_matches_from(others).is_ok()
    };
    let at = (1..words.len()).find(is_cause)?;
    Some(format!("--{}", name_of(&words[at])))
}

/// A value that belongs to another option. `arg`: as clap writes it, `--backend <B>`.
fn wrong_value(arg: &str, value: &str) -> Option<String> {
    let name = name_of(arg).split(' ').next()?;
    let value_is = |values: &[&str]| values.contains(&value.to_lowercase().as_str());
    let (.., hint) = VALUES.iter().find(|(option, values, _)| *option == name && value_is(values))?;
    Some(format!("invalid value '{value}' for '{arg}': {hint}"))
}

/// The command that the words select, with its path from the program on (`pt bench trace`).
fn command_of<'a>(root: &'a Command, words: &[String]) -> (String, &'a Command) {
    let (mut path, mut command) = (root.get_name().to_owned(), root);
    for word in words.iter().skip(1).filter(|word| !word.starts_with('-')) {
        let Some(next) = command.find_subcommand(word) else { break };
        path = format!("{path} {}", next.get_name());
        command = next;
    }
    (path, command)
}

fn unknown_argument(
    word: &str,
    root: &Command,
    path: &str,
    command: &Command,
    words: &[String],
) -> Option<String> {
    if !word.starts_with('-') {
        return stray_word(word, path, command, words);
    }
    if word.parse::<f64>().is_ok() {
        let at = words.iter().position(|other| other.starts_with(word)).unwrap_or(0);
        let before = words[..at].last().and_then(|other| option(command, name_of(other)));
        // Of `-8x8` the parser says `-8`.
        let whole = words.get(at).map_or(word, String::as_str);
        return before
            .map(|arg| format!("a negative number is not possible here: {whole} for {}", describe(arg)));
    }
    let is_long = word.starts_with("--");
    if command.has_subcommands()
        && let Some(example) = command.get_subcommands().find(|next| takes(next, word))
    {
        let name = example.get_name();
        return Some(format!(
            "{word} is an option of a command and stands after it, for example {path} {name} {word}"
        ));
    }
    // `-size 8x8` reaches the parser as `-s`: the word itself says what was meant.
    let single = |other: &&String| !is_long && other.starts_with(word) && !other.starts_with("--");
    if let Some(whole) = words.iter().find(single)
        && let Some(arg) = option(command, name_of(whole))
    {
        return Some(format!("{whole}: options with long names have two dashes: {}", describe(arg)));
    }
    let name = name_of(word);
    // An option's own name written otherwise: `--Size`, `--max_bounces`.
    let plain = name.to_lowercase().replace('_', "-");
    if plain != name
        && let Some(arg) = option(command, &plain)
    {
        return Some(format!("{word} is no option of {path}; use {}", describe(arg)));
    }
    let group = OPTIONS.iter().find(|group| group.contains(&plain.as_str())).copied().unwrap_or_default();
    let here: Vec<_> = group.iter().filter_map(|name| named(command, name)).collect();
    if !here.is_empty() {
        let uses: Vec<_> = here.into_iter().map(describe).collect();
        return Some(format!("{word} is no option of {path}; use {}", uses.join(", or ")));
    }
    if let Some(place) = place_of(&plain, group.first().copied(), path, command, words) {
        return Some(format!("{word} is no option of {path}; {place}"));
    }
    // Every command that takes a scene says so in its own way.
    if group.first().is_none_or(|name| *name == "scene") {
        return None;
    }
    let mut elsewhere = Vec::new();
    commands_with(root, root.get_name(), group, &mut elsewhere);
    // Commands themselves before those of a group of commands.
    let (there, option) = elsewhere.iter().min_by_key(|(path, _)| path.split(' ').count())?;
    Some(format!("{path} has no option {word} and none like it; {there} has --{option}"))
}

/// Where the command has what the option `name`, or the first of its group, stands for: a knob, a file, or nowhere.
fn place_of(
    name: &str,
    group: Option<&str>,
    path: &str,
    command: &Command,
    words: &[String],
) -> Option<String> {
    let is_here = |(at, what, _): &&(&str, &str, &str)| {
        path.split(' ').nth(1) == Some(*at) && (name == *what || group == Some(*what))
    };
    if let Some((.., place)) = PLACES.iter().find(is_here) {
        return Some((*place).to_owned());
    }
    let sets = option(command, "set").and_then(placeholder) == Some(SETS_KNOBS);
    let is_meant =
        |names: &[&str]| names.contains(&name) || group.is_some_and(|group| names.contains(&group));
    let (_, key, fixed) = KNOBS.iter().find(|(names, ..)| sets && is_meant(names))?;
    if !key.contains('.') {
        return Some(format!("pt knobs {key} lists what --set takes for it: --set {key}.KEY=VALUE"));
    }
    let at = words.iter().position(|word| word.starts_with("--") && name_of(word).eq_ignore_ascii_case(name));
    let given = at.and_then(|at| match words[at].split_once('=') {
        Some((_, value)) => Some(value),
        None => words.get(at + 1).map(String::as_str).filter(|next| !next.starts_with('-')),
    });
    Some(format!("use --set {key}={}", fixed.or(given).unwrap_or("VALUE")))
}

/// A word where no argument is expected.
fn stray_word(word: &str, path: &str, command: &Command, words: &[String]) -> Option<String> {
    // A value that may be left out stands behind `=`.
    let before = words.windows(2).find(|pair| pair[1] == word && pair[0].starts_with("--"));
    if let Some(arg) = before.and_then(|pair| option(command, name_of(&pair[0])))
        && arg.is_require_equals_set()
    {
        let name = arg.get_long().unwrap_or_default();
        return Some(format!(
            "unexpected argument '{word}': --{name} takes its value with =, --{name}={word}"
        ));
    }
    let is = |kinds: &[&str]| {
        let extension = Path::new(word).extension().map(|e| e.to_string_lossy().to_lowercase());
        extension.is_some_and(|e| kinds.contains(&e.as_str()))
    };
    let hint = if is(&["png", "exr", "jpg", "jpeg"]) && option(command, "output").is_some() {
        format!("the image to write is given by -o {word}")
    } else if is(&["hdr", "exr"]) && option(command, "env").is_some() {
        format!("an environment is given by --env {word}")
    } else if let Some(arg) = option(command, "scene") {
        format!("the scene is given by {}", describe(arg))
    } else {
        let positionals = command.get_positionals().count();
        let takes = match positionals {
            0 => "no arguments besides its options".to_owned(),
            1 => "one argument besides its options".to_owned(),
            n => format!("{n} arguments besides its options"),
        };
        format!("{path} takes {takes}")
    };
    Some(format!("unexpected argument '{word}': {hint}"))
}

fn unknown_command(error: &Error, word: &str, path: &str, command: &Command) -> Option<String> {
    let group = COMMANDS.iter().find(|group| group.contains(&word.to_lowercase().as_str()));
    if let Some(meant) = group.and_then(|group| command.find_subcommand(group[0])) {
        let name = meant.get_name();
        return Some(format!("'{word}' is no command of {path}; use {path} {name}"));
    }
    let is_scene = [".gltf", ".glb"].iter().any(|end| word.to_lowercase().ends_with(end));
    if is_scene && command.find_subcommand("render").is_some() {
        return Some(format!("'{word}' is no command of {path}; use {path} render {word} -o OUT.png"));
    }
    let names: Vec<_> = command.get_subcommands().map(Command::get_name).collect();
    let is_like_none = error.get(ContextKind::SuggestedSubcommand).is_none();
    is_like_none.then(|| format!("'{word}' is no command of {path}; the commands are {}", names.join(", ")))
}

/// Without dashes and value.
fn name_of(word: &str) -> &str {
    word.trim_start_matches('-').split('=').next().unwrap_or_default()
}

/// How clap writes an argument, with the first sentence of its help if it is one of the command.
fn described(text: &str, command: &Command) -> String {
    let is_it = |arg: &&Arg| match arg.get_long() {
        Some(name) => text.starts_with("--") && name_of(text).split(' ').next() == Some(name),
        None => placeholder(arg).is_some_and(|name| text.starts_with(&format!("<{name}>"))),
    };
    let arg = command.get_arguments().find(is_it);
    let sentence = arg.map(first_sentence).filter(|sentence| !sentence.is_empty());
    sentence.map_or(text.to_owned(), |sentence| format!("{text} ({sentence})"))
}

fn takes(command: &Command, word: &str) -> bool {
    let short = |arg: &Arg| arg.get_short().is_some_and(|short| word == format!("-{short}"));
    option(command, name_of(word)).is_some() || command.get_arguments().any(short)
}

fn option<'a>(command: &'a Command, name: &str) -> Option<&'a Arg> {
    command.get_arguments().find(|arg| !arg.is_hide_set() && arg.get_long() == Some(name))
}

/// The option of this name, or the argument without a name whose placeholder it is (`SCENE`).
fn named<'a>(command: &'a Command, name: &str) -> Option<&'a Arg> {
    option(command, name).or_else(|| {
        command
            .get_positionals()
            .find(|arg| placeholder(arg).is_some_and(|text| text.eq_ignore_ascii_case(name)))
    })
}

fn placeholder(arg: &Arg) -> Option<&str> {
    arg.get_value_names().and_then(|names| names.first()).map(|name| name.as_str())
}

/// How it is written, and the first sentence of its help.
fn describe(arg: &Arg) -> String {
    let takes_value = arg.get_action().takes_values();
    let value = placeholder(arg).filter(|_| takes_value).map(|name| format!(" <{name}>")).unwrap_or_default();
    let written = match arg.get_long() {
        Some(name) => format!("--{name}{value}"),
        None => format!("the argument{value}, which has no name in front"),
    };
    let sentence = first_sentence(arg);
    if sentence.is_empty() { written } else { format!("{written} ({sentence})") }
}

fn first_sentence(arg: &Arg) -> String {
    let help = arg.get_help().map(|help| help.to_string()).unwrap_or_default();
    help.split(". ").next().unwrap_or_default().trim_end_matches('.').trim().to_owned()
}

fn commands_with(command: &Command, path: &str, group: &[&str], found: &mut Vec<(String, String)>) {
    let arg = group.iter().find_map(|name| option(command, name)).and_then(Arg::get_long);
    found.extend(arg.map(|name| (path.to_owned(), name.to_owned())));
    for next in command.get_subcommands() {
        commands_with(next, &format!("{path} {}", next.get_name()), group, found);
    }
}

/// The message and the hints of a clap error without its usage block, on one line.
fn flat(rendered: &str) -> String {
    let message = rendered.split("\n\nUsage:").next().unwrap_or_default();
    let message = message.split("\n\nFor more information").next().unwrap_or_default();
    let message = message.strip_prefix("error: ").unwrap_or(message);
    let message = NUMBERS.iter().fold(message.to_owned(), |text, (from, to)| text.replace(from, to));
    let blocks: Vec<_> =
        message.split("\n\n").map(super::join_lines).filter(|block| !is_noise(block)).collect();
    plain_range(&blocks.join("; "))
}

/// Nothing, or the tip to pass an option as a value, which nobody means.
fn is_noise(block: &str) -> bool {
    block.is_empty() || block.starts_with("tip: to pass '-")
}

/// `0 is not in 1..=8` as `expected a whole number of 1 to 8`.
fn plain_range(text: &str) -> String {
    const MARK: &str = " is not in ";
    let range = || {
        let (before, rest) = text.split_once(MARK)?;
        let (least, most) = rest.split(';').next()?.split_once("..")?;
        let (least, most) = (least.parse::<i64>().ok()?, most.trim_start_matches('='));
        let head = before.rsplit_once(": ")?.0;
        // The end of a range without one is that of the type.
        let most = match most.parse::<u64>() {
            Ok(most) if most < u64::from(u32::MAX) => format!("to {most}"),
            _ => "or more".to_owned(),
        };
        Some(format!("{head}: expected a whole number of {least} {most}"))
    };
    range().unwrap_or_else(|| text.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::value_parser;

    fn program() -> Command {
        let size = || Arg::new("size").long("size").value_name("WxH").help("Image size. More of it.");
        let scene = Arg::new("file").value_name("SCENE").required(true).help("A scene");
        let render = Command::new("render").args([
            scene.clone(),
            size(),
            Arg::new("frames").long("frames").value_name("N").help("Number of frames"),
            Arg::new("output").long("output").short('o').value_name("OUT").help("Image to write"),
            Arg::new("env").long("env").value_name("F").help("Environment"),
            Arg::new("look").long("look").value_name("EYE"),
            Arg::new("vfov").long("vfov").requires("look"),
            Arg::new("rounds").long("rounds").value_name("R").value_parser(value_parser!(u32).range(1..)),
            Arg::new("columns").long("columns").value_name("C").value_parser(value_parser!(u32).range(1..=8)),
        ]);
        let bloom = Arg::new("bloom").long("bloom").num_args(0..=1).require_equals(true);
        let backend = Arg::new("backend").long("backend").value_name("B").value_parser(["auto", "compute"]);
        let capture = Command::new("capture").args([
            scene.clone(),
            Arg::new("set").long("set").value_name(SETS_KNOBS),
            bloom,
            backend,
        ]);
        let replay = Command::new("replay").arg(scene.clone());
        let reference = Command::new("reference").args([
            scene,
            Arg::new("spp").long("spp").value_name("N").help("Samples per pixel"),
            Arg::new("bounces").long("max-bounces").value_name("B"),
        ]);
        let passes =
            Command::new("passes").arg(Arg::new("scene").long("scene").value_name("S").help("Scene"));
        Command::new("pt").subcommands([render, reference, passes, capture, replay]).subcommand_required(true)
    }

    fn refused(line: &str) -> String {
        let words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        let error = program().try_get_matches_from(&words).unwrap_err();
        let text = message(&error, &program(), &words);
        assert_eq!(text.lines().count(), 1, "{text}");
        text
    }

    #[test]
    fn options_of_other_names_are_understood() {
        for (line, says) in [
            ("pt render s --spp 4", "use --frames <N> (Number of frames) (see pt render --help)"),
            ("pt reference s --frames=4", "use --spp <N> (Samples per pixel)"),
            ("pt render s --width 640", "use --size <WxH> (Image size)"),
            ("pt render s --resolution=640x3", "use --size <WxH>"),
            ("pt render --scene s", "the argument <SCENE>, which has no name in front"),
            ("pt render s --out a.png", "use --output <OUT>"),
            ("pt render s -size 8x8", "-size: options with long names have two dashes: --size <WxH>"),
            ("pt render s --Size 8x8", "use --size <WxH>"),
            ("pt reference s --max_bounces 2", "use --max-bounces <B>"),
            (
                "pt render s --bounces 2",
                "pt render has no option --bounces and none like it; pt reference has --max-bounces",
            ),
            ("pt render s out.png", "the image to write is given by -o out.png"),
            ("pt render s sky.hdr", "--env sky.hdr"),
            ("pt passes cornell", "the scene is given by --scene <S>"),
            ("pt reference s t", "pt reference takes one argument besides its options"),
            ("pt render s --frames -5", "a negative number is not possible here: -5 for --frames <N>"),
            ("pt a.glb", "use pt render a.glb -o OUT.png"),
            ("pt trace s", "use pt reference"),
            (
                "pt cornell",
                "'cornell' is no command of pt; the commands are render, reference, passes, capture, replay",
            ),
            (
                "pt --size 8x8 render s",
                "--size is an option of a command and stands after it, for example pt render --size",
            ),
            ("pt -o a.png render s", "for example pt render -o"),
            ("pt render s --frames -8x8", "-8x8 for --frames <N>"),
            ("pt render", "pt render needs <SCENE> (A scene)"),
            ("pt render s --vfov 40", "--vfov needs --look <EYE> (see pt render --help)"),
            ("pt render s --env e.hdr --vfov 40", "--vfov needs --look <EYE> (see pt render --help)"),
            ("pt render s --rounds 0", "for '--rounds <R>': expected a whole number of 1 or more (see"),
            ("pt render s --columns 9", "for '--columns <C>': expected a whole number of 1 to 8 (see"),
            ("pt capture s --denoise svgf", "use --set denoise.variant=svgf (see"),
            ("pt capture s --denoiser=svgf", "use --set denoise.variant=svgf (see"),
            ("pt capture s --sampler", "use --set lights.sampler=VALUE (see"),
            ("pt capture s --bounces 2", "use --set indirect.bounces=2 (see"),
            ("pt capture s --taa", "use --set post.taa.enabled=true (see"),
            ("pt capture s --checkerboard off", "--set checkerboard.KEY=VALUE (see"),
            ("pt replay d --size 8x8", "--size is no option of pt replay; frames of a capture have its size"),
            ("pt capture s --bloom gaussian", "--bloom takes its value with =, --bloom=gaussian"),
            ("pt capture s --backend cpu", "is chosen by --device"),
        ] {
            let text = refused(line);
            assert!(text.contains(says), "{line}: {text}");
        }
    }

    /// What the tables do not know stays as clap says it, with its tip as a clause of its own.
    #[test]
    fn other_mistakes_keep_their_message() {
        let text = refused("pt render s --framez 4");
        assert!(
            text.starts_with("unexpected argument '--framez' found; tip: ") && text.contains("--frames"),
            "{text}"
        );
        assert!(refused("pt render").contains("<SCENE>"));
        let text = refused("pt render s --verbose");
        assert_eq!(text, "unexpected argument '--verbose' found (see pt render --help)");
    }

    /// The first name of a group is one that a command has; no name stands in two groups.
    #[test]
    fn names_are_in_one_group() {
        for table in [OPTIONS, COMMANDS] {
            let mut names: Vec<_> = table.iter().flat_map(|group| group.iter()).collect();
            let all = names.len();
            names.sort();
            names.dedup();
            assert_eq!(names.len(), all);
        }
    }
}
