//! The book and all other Markdown files: links lead somewhere, and what is generated is not stale.

use super::pt;
use pt_app::frame::FrameStage;
use pt_shaders::NamedEnum;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};

fn root() -> PathBuf {
    fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).unwrap()
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// All Markdown files of the repository.
fn markdown_files() -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![root()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap()) {
            let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
            let kind = entry.file_type().unwrap();
            if kind.is_dir() && !name.starts_with('.') && name != "target" && name != "out" {
                folders.push(path);
            } else if kind.is_file() && name.ends_with(".md") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Lines that are not code, with code spans left out.
fn prose(text: &str) -> impl Iterator<Item = String> {
    let mut fenced = false;
    text.lines().filter_map(move |line| {
        let is_fence = line.trim_start().starts_with("```");
        fenced ^= is_fence;
        (!fenced && !is_fence && !line.starts_with("    "))
            .then(|| line.split('`').step_by(2).collect::<Vec<_>>().join(" "))
    })
}

/// What `](...)` names.
fn links(text: &str) -> Vec<String> {
    let of_line = |line: String| {
        let targets = line
            .split("](")
            .skip(1)
            .filter_map(|rest| rest.split_once(')').map(|(target, _)| target.to_owned()));
        targets.collect::<Vec<_>>()
    };
    prose(text).flat_map(of_line).collect()
}

/// The anchors of the headings, as mdBook and others derive them.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut fenced = false;
    let headings = text.lines().filter(move |line| {
        fenced ^= line.trim_start().starts_with("```");
        !fenced && line.starts_with('#')
    });
    let anchor = |heading: &str| -> String {
        let words = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = words.chars().filter(|c| c.is_alphanumeric() || "-_ ".contains(*c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(anchor).collect()
}

/// A path without `..`.
fn normal(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut done, part| {
        match part {
            Component::ParentDir => drop(done.pop()),
            part => done.push(part),
        }
        done
    })
}

fn includes(text: &str) -> Vec<String> {
    let rest = text.split("{{#include ").skip(1);
    rest.filter_map(|rest| rest.split_once("}}").map(|(name, _)| name.trim().to_owned())).collect()
}

/// What is wrong with the links and includes of a file.
fn faults(path: &Path, text: &str) -> Vec<String> {
    let folder = path.parent().unwrap();
    let mut faults = Vec::new();
    let mut fault = |what: String| faults.push(format!("{}: {what}", path.display()));
    for link in links(text) {
        if link.contains("://") || link.starts_with("mailto:") {
            continue;
        }
        let (name, anchor) =
            link.split_once('#').map_or((&link[..], None), |(name, anchor)| (name, Some(anchor)));
        let target = if name.is_empty() { path.to_owned() } else { normal(&folder.join(name)) };
        if !target.exists() {
            fault(format!("the link {link} leads nowhere"));
            continue;
        }
        let page = if target.is_dir() { target.join("README.md") } else { target };
        if let Some(anchor) = anchor
            && !(page.exists() && anchors(&read(&page)).contains(anchor))
        {
            fault(format!("{link}: no heading has that anchor"));
        }
    }
    for include in includes(text) {
        let (name, anchor) =
            include.split_once(':').map_or((&include[..], None), |(name, anchor)| (name, Some(anchor)));
        let target = normal(&folder.join(name));
        match (target.exists(), anchor) {
            (false, _) => fault(format!("the included file {name} is not there")),
            (true, Some(anchor)) if !read(&target).contains(&format!("ANCHOR: {anchor} ")) => {
                fault(format!("{name} has no anchor {anchor}"));
            }
            _ => {}
        }
    }
    faults
}

#[test]
fn no_link_is_dead() {
    let files = markdown_files();
    assert!(files.len() > 40, "{} Markdown files", files.len());
    let found: Vec<_> = files.iter().flat_map(|path| faults(path, &read(path))).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// The test itself finds what it is there for.
#[test]
fn dead_links_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.md");
    fs::write(folder.path().join("other.md"), "# A heading: `code` (1)\n<!-- ANCHOR: part -->\n").unwrap();
    let text = "[a](other.md) ![b](gone.png)\n[c](other.md#a-heading-code-1) [d](other.md#none)\n`[e](gone.md)`\n    [f](gone.md)\n\
                {{#include other.md:part}} {{#include other.md:whole}} {{#include gone.md}}\n";
    let found = faults(&page, text);
    assert_eq!(found.len(), 4, "{found:?}");
    for (fault, part) in
        found.iter().zip(["gone.png", "other.md#none", "no anchor whole", "gone.md is not there"])
    {
        assert!(fault.contains(part), "{fault}");
    }
}

/// The example of the tutorial finds its places in pt-denoise, and is as short as the tutorial says.
#[test]
fn the_box_denoiser_can_be_added() {
    let (folder, root) = (tempfile::tempdir().unwrap(), root());
    let copy = folder.path().join("pt-denoise");
    for part in ["src", "src/variants", "shaders"] {
        fs::create_dir_all(copy.join(part)).unwrap();
        for entry in fs::read_dir(root.join("pt-denoise").join(part)).unwrap().map(|entry| entry.unwrap()) {
            if entry.file_type().unwrap().is_file() {
                fs::copy(entry.path(), copy.join(part).join(entry.file_name())).unwrap();
            }
        }
    }
    let add = || {
        let script = root.join("examples/box_denoiser/add.sh");
        std::process::Command::new(script).arg(folder.path()).output().unwrap()
    };
    let done = add();
    assert!(done.status.success(), "{done:?}");
    let mut added = 0;
    for file in ["src/records.rs", "src/variants/mod.rs", "src/variants/low_frequency.rs"] {
        let (before, after) = (read(&root.join("pt-denoise").join(file)), read(&copy.join(file)));
        let new = after.lines().count() - before.lines().count();
        assert!(new > 0 && after.contains("Box") && !before.contains("Denoiser::Box"), "{file}");
        added += new;
    }
    for file in ["src/variants/box_filter.rs", "shaders/box_filter.comp"] {
        added += read(&copy.join(file)).lines().count();
    }
    assert!((40..60).contains(&added), "{added} lines");
    assert_eq!(add().status.code(), Some(2), "a second time");
}

/// The summary lists every page of the book once, and every stage has a page that includes the README of its crate.
#[test]
fn every_page_and_every_stage_is_in_the_book() {
    let source = root().join("docs/src");
    let mut listed: Vec<_> =
        links(&read(&source.join("SUMMARY.md"))).iter().map(|link| source.join(link)).collect();
    listed.sort();
    let is_page = |path: &PathBuf| {
        path.starts_with(&source)
            && !path.ends_with("SUMMARY.md")
            && !path.starts_with(source.join("generated"))
    };
    let pages: Vec<_> = markdown_files().into_iter().filter(is_page).collect();
    assert_eq!(listed, pages);
    for stage in FrameStage::VALUES.iter().filter(|stage| **stage != FrameStage::Scene) {
        let page = read(&source.join(format!("stages/{}.md", stage.name())));
        let crate_name = format!("pt-{}", stage.name());
        assert!(
            page.contains(&format!("{{{{#include ../../../{crate_name}/README.md}}}}")),
            "{}: {page}",
            stage.name()
        );
    }
}

/// The frame that the book shows; its size makes bytes per pixel nearly those of large frames.
const FRAME: &str = "passes --json --scene cornell --size 240x136 --set denoise.variant=asvgf --set post.taa.enabled=true \
                     --set gbuffer.jitter=halton --set gbuffer.replaced_motion=search --backend compute";

fn pass_table() -> String {
    let mut line = FRAME.to_owned();
    if let Ok(device) = std::env::var("PT_TEST_DEVICE") {
        line.push_str(&format!(" --device {device}"));
    }
    let done = pt(&line);
    assert!(done.status.success(), "pt {line}: {done:?}");
    let listed: Value = serde_json::from_slice(&done.stdout).unwrap();
    let passes = listed["passes"].as_array().unwrap();
    let names = |list: &Value| {
        let names = list.as_array().unwrap().iter().map(|name| format!("`{}`", name.as_str().unwrap()));
        names.collect::<Vec<_>>().join(" ")
    };
    let mut text = String::from(
        "<!-- generated by the test of pt-app/tests/knobs/book.rs -->\n| pass | reads | writes | bytes a pixel |\n| --- | --- | --- | --- |\n",
    );
    for pass in passes {
        let bytes = pass["bytes"].as_f64().unwrap() / (240.0 * 136.0);
        let bound = if pass["bytes_are_upper_bound"] == true { "at most " } else { "" };
        text.push_str(&format!(
            "| {} | {} | {} | {bound}{bytes:.1} |\n",
            pass["name"].as_str().unwrap(),
            names(&pass["reads"]),
            names(&pass["writes"])
        ));
    }
    let command = FRAME.replace(" --json", "").split_whitespace().collect::<Vec<_>>().join(" ");
    text.push_str(&format!("\n    pt {command}\n"));
    text
}

/// `PT_BLESS=1` writes the table anew.
#[test]
fn the_table_of_passes_is_not_stale() {
    let path = root().join("docs/src/generated/passes.md");
    let table = pass_table();
    if std::env::var_os("PT_BLESS").is_some() {
        fs::write(&path, &table).unwrap();
    }
    assert!(read(&path) == table, "{}: stale, PT_BLESS=1 writes it", path.display());
    // The costs were measured on a GPU, so that they cannot be compared; but they are of the passes that there are now.
    let costs = read(&root().join("docs/src/generated/costs.md"));
    let first_cells = |text: &str| -> BTreeMap<String, usize> {
        let rows = text
            .lines()
            .filter_map(|line| line.strip_prefix("| ")?.split_once(" |").map(|(cell, _)| cell.to_owned()));
        let mut cells = BTreeMap::new();
        // Uploads depend on what moves in the scene, and the camera's solids on whether there is glass.
        let of_stages =
            rows.filter(|cell| !cell.starts_with("upload ") && !["pass", "---"].contains(&&cell[..]));
        of_stages.for_each(|cell| *cells.entry(cell).or_default() += 1);
        cells
    };
    let (now, measured) = (first_cells(&table), first_cells(&costs));
    let missing: Vec<_> = now.keys().filter(|pass| !measured.contains_key(*pass)).collect();
    assert!(
        missing.is_empty(),
        "docs/src/generated/costs.md lacks {missing:?}; measure again: pt bench frame --profile realtime --json FILE, then scripts/book_costs.py FILE"
    );
}
