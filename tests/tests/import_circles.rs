//! No circle of imports between the files of a library. A file may name the modules around it, and they name it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A path within the crate. That of a module stands for its file.
type Segments = Vec<String>;

#[derive(Default)]
struct Module {
    imports: BTreeSet<Segments>,
    /// What `pub use` passes on, and from where: who imports it imports that. `None` = from another crate.
    passes_on: BTreeMap<String, Option<Segments>>,
}

/// Adds the files below a folder, if it is there, which is module `at`; programs are other crates.
fn find(folder: &Path, at: &[String], files: &mut BTreeMap<Segments, PathBuf>) {
    for path in fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap().path()) {
        let name = path.file_stem().unwrap().to_str().unwrap();
        let here = if ["mod", "lib"].contains(&name) { at.to_vec() } else { [at, &[name.into()]].concat() };
        if path.is_dir() && !path.ends_with("src/bin") {
            find(&path, &here, files);
        } else if path.extension().is_some_and(|e| e == "rs") && !path.ends_with("src/main.rs") {
            files.insert(here, path);
        }
    }
}

/// What the file of module `at` means by a path; `None` if it is neither in this crate nor a module of the file.
fn absolute(at: &[String], path: &str, files: &BTreeMap<Segments, PathBuf>) -> Option<Segments> {
    let segments = path.split("::").filter(|segment| !["", "*", "self"].contains(segment));
    let path: Segments = segments.map(String::from).collect();
    let ups = path.iter().take_while(|segment| *segment == "super").count();
    match path.first()?.as_str() {
        "crate" => Some(path[1..].to_vec()),
        "super" => Some([&at[..at.len().saturating_sub(ups)], &path[ups..]].concat()),
        child => files.contains_key(&[at, &[child.into()]].concat()).then(|| [at, &path].concat()),
    }
}

/// Reads a file up to its tests. Names that `as` gives are not followed.
fn read(at: &[String], files: &BTreeMap<Segments, PathBuf>) -> Module {
    let text = fs::read_to_string(&files[at]).unwrap();
    let code = text.split("#[cfg(test)]\nmod ").next().unwrap();
    let (mut found, mut is_public, mut passes_on) = (Module::default(), false, false);
    // The front of what is within braces of a `use`, and of the braces around them.
    let (mut word, mut fronts) = (String::new(), Vec::<String>::new());
    for c in code.lines().flat_map(|line| line.split("//").next().unwrap().chars().chain(['\n'])) {
        if c.is_alphanumeric() || c == '_' || c == ':' {
            word.push(c);
            continue;
        }
        let path = fronts.last().cloned().unwrap_or_default() + &word;
        let place = absolute(at, &path, files).filter(|_| path.contains("::") && !word.is_empty());
        if c == '{' && path.ends_with("::") {
            fronts.push(path);
        } else if passes_on {
            found.passes_on.insert(word.rsplit("::").next().unwrap().into(), place);
        } else {
            found.imports.extend(place);
        }
        if c == '}' {
            fronts.pop();
        }
        passes_on = c != ';' && (passes_on || word == "use" && is_public);
        is_public = word == "pub" || is_public && !"{};".contains(c);
        word.clear();
    }
    found
}

/// The module whose file has what a path names.
fn place(path: &[String], modules: &BTreeMap<Segments, Module>) -> Option<Segments> {
    let (at, rest) = path.split_at((0..=path.len()).rev().find(|&n| modules.contains_key(&path[..n]))?);
    match rest.first().and_then(|name| modules[at].passes_on.get(name)) {
        Some(from) => place(&[from.as_deref()?, &rest[1..]].concat(), modules),
        None => Some(at.to_vec()),
    }
}

#[test]
fn files_do_not_import_each_other_in_circles() {
    let mut imports: BTreeMap<PathBuf, BTreeSet<PathBuf>> = BTreeMap::new();
    for member in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).unwrap() {
        let mut files = BTreeMap::new();
        find(&member.unwrap().path().join("src"), &[], &mut files);
        let modules: BTreeMap<_, _> = files.keys().map(|at| (at.clone(), read(at, &files))).collect();
        for (at, module) in &modules {
            let places = module.imports.iter().filter_map(|path| place(path, &modules));
            let others = places.filter(|place| !at.starts_with(place)).map(|place| files[&place].clone());
            imports.insert(files[at].clone(), others.collect());
        }
    }
    assert!(imports.values().flatten().count() > 500, "the files were not read");
    // Who imports nothing that is left, or is imported by none that is left, is in no circle.
    for _ in 0..imports.len() {
        let imported: BTreeSet<PathBuf> = imports.values().flatten().cloned().collect();
        imports.retain(|file, files| !files.is_empty() && imported.contains(file));
        let left: BTreeSet<PathBuf> = imports.keys().cloned().collect();
        imports.values_mut().for_each(|files| files.retain(|file| left.contains(file)));
    }
    assert!(imports.is_empty(), "files in circles, and what they import: {imports:#?}");
}
