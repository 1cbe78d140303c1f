//! The report of a result folder, on a folder that the tests write: its text, and the page in a headless browser.
//!
//! `PT_SCREENSHOTS=DIR` keeps pictures of the page in both themes and two widths.

mod browser;
mod folder;

use browser::Browser;
use pt_study::record::CellRecord;
use pt_study::report::write;
use std::fs;
use std::path::Path;

fn written() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    folder::write(dir.path());
    dir
}

#[test]
fn the_report_is_one_file_that_escapes_names() {
    let dir = written();
    let path = write(dir.path()).unwrap();
    assert_eq!(path, dir.path().join("report.html"));
    let page = fs::read_to_string(path).unwrap();
    assert!(
        !page.contains("<b>bold</b>")
            && page.contains("&lt;b&gt;bold&lt;&#x2f;b&gt; &amp; &quot;quoted&quot;")
    );
    for wanted in [
        "no difference shown",
        "Which denoiser brings one sample a pixel nearest",
        "pt study studies&#x2f;denoiser.toml -o out&#x2f;denoiser",
        "0123456789abcdef0123456789abcdef01234567-dirty",
        "llvmpipe (LLVM 19.1.7, 256 bits)",
        "Mesa 25.0.7",
        "--set denoise.variant=asvgf",
    ] {
        assert!(page.contains(wanted), "{wanted}");
    }
    // The name space of SVG is a name, not an address that anything loads.
    let addresses = page.replace("http://www.w3.org/2000/svg", "");
    assert!(!addresses.contains("http://") && !addresses.contains("https://"));
    // Each of 12 pictures, 12 errors and 2 references once.
    assert_eq!(page.matches("data:image/png;base64,").count(), 26);
}

#[test]
fn pictures_that_do_not_fit_are_left_out_and_named() {
    let dir = written();
    // 26 files of 1 MB are 35 MB as text. Nothing reads more than the first bytes.
    let mut large = fs::read(dir.path().join("images/cornell-reference.png")).unwrap();
    large.resize(1_000_000, 0);
    for entry in fs::read_dir(dir.path().join("images")).unwrap() {
        fs::write(entry.unwrap().path(), &large).unwrap();
    }
    let page = fs::read_to_string(write(dir.path()).unwrap()).unwrap();
    assert!(page.len() < 20_000_000 && page.len() > 18_000_000, "{}", page.len());
    assert!(page.contains("of 26 pictures are left out, from: gallery."), "the first view is whole");
}

#[test]
fn pictures_outside_the_folder_are_not_shown() {
    // Pictures that are there, but beside the folder: by a path, by an absolute path, by a link.
    let outer = tempfile::tempdir().unwrap();
    let dir = outer.path().join("results");
    fs::create_dir(&dir).unwrap();
    folder::write(&dir);
    let secret = outer.path().join("secret.png");
    fs::copy(dir.join("images/cornell-reference.png"), &secret).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink(&secret, dir.join("images/link.png")).unwrap();
    let (mut cells, timings) = folder::cells();
    let absolute = secret.display().to_string();
    for path in ["../secret.png", &absolute, "images/link.png", "study.json", "images/none.png"] {
        cells[0].images.insert("picture".into(), path.into());
        folder::write_records(&dir, &folder::study(), &cells, &timings);
        let page = fs::read_to_string(write(&dir).unwrap()).unwrap();
        assert!(page.contains("no PNG files inside the result folder (1): "), "{path}");
        assert_eq!(page.matches("data:image/png;base64,").count(), 25);
    }
}

#[test]
fn a_study_without_frames_times_ledger_and_pictures_has_a_report() {
    let dir = tempfile::tempdir().unwrap();
    let (mut cells, _) = folder::cells();
    for cell in &mut cells {
        cell.ledger = None;
        cell.frames.clear();
        cell.images.clear();
        cell.metrics.insert("flip".into(), None);
    }
    folder::write_records(dir.path(), &folder::study(), &cells[..7], &[]);
    fs::remove_file(dir.path().join("timings.jsonl")).unwrap();
    let page = fs::read_to_string(write(dir.path()).unwrap()).unwrap();
    assert!(page.contains("7 of 60") && !page.contains("<figure"));
}

#[test]
fn faults_of_a_folder_are_one_clear_line() {
    let message = |change: &dyn Fn(&Path)| {
        let dir = tempfile::tempdir().unwrap();
        let (cells, timings) = folder::cells();
        folder::write_records(dir.path(), &folder::study(), &cells, &timings);
        change(dir.path());
        let message = write(dir.path()).unwrap_err().to_string();
        assert!(!message.contains('\n') && !dir.path().join("report.html").exists(), "{message}");
        message
    };
    let append = |name: &'static str, text: &'static str| {
        move |dir: &Path| {
            let old = fs::read_to_string(dir.join(name)).unwrap();
            fs::write(dir.join(name), old + text).unwrap();
        }
    };
    let replace = |name: &'static str, from: &'static str, to: &'static str| {
        move |dir: &Path| {
            let old = fs::read_to_string(dir.join(name)).unwrap();
            fs::write(dir.join(name), old.replacen(from, to, 1)).unwrap();
        }
    };
    for (message, wanted) in [
        (message(&|dir| fs::remove_file(dir.join("study.json")).unwrap()), "study.json"),
        (message(&|dir| fs::write(dir.join("results.jsonl"), "").unwrap()), "holds no cell yet"),
        (
            message(&append("results.jsonl", "{\"cell\": 1}\n")),
            "results.jsonl: line 61 is damaged; run the study again",
        ),
        (message(&append("timings.jsonl", "{")), "timings.jsonl: line 61 is damaged"),
        (
            message(&replace("study.json", "\"format\": 1", "\"format\": 2")),
            "has format 2, this program reads 1",
        ),
        (
            message(&replace("study.json", "\"format\": 1", "\"form\": 1")),
            "study.json: is damaged (missing field `format`",
        ),
        (
            message(&replace("results.jsonl", "\"variant\":\"svgf\"", "\"variant\":\"x\"")),
            "belongs to variant x",
        ),
    ] {
        assert!(message.contains(wanted), "{message}");
    }
}

/// A study with one cell has no interval anywhere and says that no difference is shown.
#[test]
fn one_cell_a_variant_shows_no_difference() {
    let dir = tempfile::tempdir().unwrap();
    let (cells, timings) = folder::cells();
    let cells: Vec<CellRecord> =
        cells.into_iter().filter(|cell| cell.seed == 1 && cell.scene == "cornell").collect();
    folder::write_records(dir.path(), &folder::study(), &cells, &timings);
    let page = fs::read_to_string(write(dir.path()).unwrap()).unwrap();
    assert!(page.contains("no difference shown: <b>svgf, placebo"), "{}", page.len());
    assert!(page.contains("none is better") && page.contains("none is worse"));
    assert!(page.contains("1 seed: nothing tells the noise"));
    // Five seeds need no sentence.
    let dir = written();
    let page = fs::read_to_string(write(dir.path()).unwrap()).unwrap();
    assert!(!page.contains("seed: nothing") && !page.contains("Student"));
}

#[test]
#[cfg_attr(not(browser), ignore = "needs headless chromium: scripts/setup-browser.sh")]
fn the_page_works_in_a_browser() {
    let dir = written();
    let page = write(dir.path()).unwrap();
    let mut browser = Browser::start();
    browser.prefer("light");
    browser.open(&page, 1280, 800);
    let milliseconds = browser
        .value(
            "(() => { const t = performance.getEntriesByType('navigation')[0]; return t.loadEventStart; })()",
        )
        .as_f64()
        .unwrap();
    assert!(milliseconds > 0.0 && milliseconds < 2000.0, "opens in {milliseconds} ms");
    println!("the page opens in {milliseconds:.0} ms");

    names_are_text(&mut browser);
    figures_have_tables(&mut browser);
    tables_sort(&mut browser);
    the_slider_moves_the_split(&mut browser);
    zoom_and_pan_move_both_pictures(&mut browser);
    modes_show_what_they_say(&mut browser);
    series_can_be_hidden(&mut browser);
    commands_are_copied(&mut browser);
    browser.open(&page, 1280, 800);
    the_keyboard_reaches_everything(&mut browser);
    themes_and_widths(&mut browser, &page);
    nothing_is_requested_or_reported(&browser);
}

fn names_are_text(browser: &mut Browser) {
    let names = browser.value(
        "[...document.querySelectorAll('#answer table')][0].tBodies[0].rows.length + ' ' + \
         [...document.querySelectorAll('#answer td')].filter(td => td.textContent.trim() === '<b>bold</b> & \"quoted\"').length",
    );
    assert_eq!(names, "6 3", "rows of the first table; cells with the name, one in each of three tables");
    let placebo = browser.value(
        "[...document.querySelectorAll('#answer table tr')].find(tr => tr.textContent.includes('placebo')).textContent",
    );
    assert!(placebo.as_str().unwrap().contains("no difference shown"), "{placebo}");
    // The variant without a denoiser is last and alone there; the baseline and the placebo share a rank.
    let ranks = browser.value(
        "[...document.querySelectorAll('#answer table')[0].tBodies[0].rows].map(r => r.cells[0].textContent.trim() + ' ' + r.cells[1].textContent.trim())",
    );
    let ranks: Vec<&str> = ranks.as_array().unwrap().iter().filter_map(|rank| rank.as_str()).collect();
    assert_eq!(ranks.last(), Some(&"6 off"), "{ranks:?}");
    assert!(ranks.contains(&"2= asvgf") && ranks.contains(&"2= placebo"), "{ranks:?}");
}

fn figures_have_tables(browser: &mut Browser) {
    let counts = browser.value(
        "[...document.querySelectorAll('figure')].map(f => [f.id, f.querySelectorAll('figcaption').length, f.querySelectorAll('details tbody tr').length])",
    );
    let counts = counts.as_array().unwrap();
    let ids: Vec<_> = counts.iter().map(|count| count[0].as_str().unwrap()).collect();
    assert_eq!(
        ids,
        [
            "frames-0",
            "cost-0",
            "frames-1",
            "cost-1",
            "frames-2",
            "cost-2",
            "ledger",
            "ledger-frames",
            "viewer"
        ]
    );
    assert!(counts.iter().all(|count| count[1] == 1 && count[2].as_u64() > Some(0)), "{counts:?}");
    // The ledger adds up in its table.
    let sums = browser.value(
        "[...document.querySelectorAll('#ledger tbody tr')].map(tr => { const n = [...tr.cells].slice(2, -1).map(td => Number(td.dataset.sort)); \
         const total = n.pop(); return Math.abs(n.reduce((a, b) => a + b) - total) / total; })",
    );
    assert!(sums.as_array().unwrap().iter().all(|error| error.as_f64().unwrap() < 1e-9), "{sums}");
}

fn tables_sort(browser: &mut Browser) {
    let table = "document.querySelectorAll('#answer table')[0]";
    let column = |number: usize, text: bool| {
        let value = if text { "textContent.trim()" } else { "dataset.sort" };
        format!("[...{table}.tBodies[0].rows].map(row => row.cells[{number}].{value})")
    };
    let numbers = |browser: &mut Browser| -> Vec<f64> {
        let values = browser.value(&column(3, false));
        values.as_array().unwrap().iter().map(|v| v.as_str().unwrap().parse().unwrap()).collect()
    };
    let sort_of =
        format!("[...{table}.tHead.rows[0].cells].map(th => th.getAttribute('aria-sort')).join(' ')");
    browser.click("#answer th:nth-child(4) button");
    let ascending = numbers(browser);
    assert!(ascending.is_sorted() && ascending.len() == 6, "{ascending:?}");
    assert!(browser.value(&sort_of).as_str().unwrap().starts_with("none none none ascending none"));
    browser.click("#answer th:nth-child(4) button");
    let descending = numbers(browser);
    assert!(descending.is_sorted_by(|a, b| a >= b), "{descending:?}");
    assert!(browser.value(&sort_of).as_str().unwrap().starts_with("none none none descending none"));
    // By the keyboard, a column of names.
    browser.value("document.querySelector('#answer th:nth-child(2) button').focus()");
    browser.press("Enter");
    let names = browser.value(&column(1, true));
    let names: Vec<&str> = names.as_array().unwrap().iter().filter_map(|name| name.as_str()).collect();
    let mut sorted = names.clone();
    sorted.sort_unstable();
    assert_eq!(names, sorted);
}

fn the_slider_moves_the_split(browser: &mut Browser) {
    let split = "getComputedStyle(document.getElementById('pane-b')).clipPath + ' ' + document.getElementById('line').offsetLeft";
    browser.value("document.getElementById('split').focus()");
    let before = browser.value(split);
    for _ in 0..20 {
        browser.press("ArrowRight");
    }
    let after = browser.value(split);
    assert_ne!(before, after);
    assert!(after.as_str().unwrap().starts_with("inset(0px 0px 0px 60%)"), "{after}");
    let line = browser
        .value("document.getElementById('line').offsetLeft / document.getElementById('stage').clientWidth");
    assert!((line.as_f64().unwrap() - 0.6).abs() < 0.01, "{line}");
}

/// Where both pictures are: translation in pixels and scale.
fn transforms(browser: &mut Browser) -> [Vec<f64>; 2] {
    ["image-a", "image-b"].map(|id| {
        let matrix = browser.value(&format!(
            "(() => {{ const m = new DOMMatrix(getComputedStyle(document.getElementById('{id}')).transform); return [m.e, m.f, m.a, m.d]; }})()"
        ));
        matrix.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
    })
}

fn zoom_and_pan_move_both_pictures(browser: &mut Browser) {
    let loaded = "[...document.querySelectorAll('#stage img')].every(image => image.complete && image.naturalWidth === 96)";
    browser.until(loaded);
    for mode in ["slider", "side"] {
        browser.click(&format!("button[data-mode={mode}]"));
        browser.click("#zoom-reset");
        browser.click("#zoom-in");
        browser.click("#zoom-in");
        let [a, b] = transforms(browser);
        assert_eq!(a, b, "{mode}");
        assert_eq!((a[2], a[3]), (4.0, 4.0));
        browser.value("document.getElementById('stage').focus()");
        browser.press("ArrowLeft");
        browser.press("ArrowDown");
        let [moved, other] = transforms(browser);
        assert_eq!(moved, other);
        assert!(moved[0] > a[0] && moved[1] < a[1], "{a:?} {moved:?}");
        browser.drag("#pane-a", (-30.0, -20.0));
        let [dragged, other] = transforms(browser);
        assert_eq!(dragged, other);
        assert!(
            (dragged[0] - moved[0] + 30.0).abs() < 2.0 && (dragged[1] - moved[1] + 20.0).abs() < 2.0,
            "{moved:?} {dragged:?}"
        );
    }
}

fn modes_show_what_they_say(browser: &mut Browser) {
    let visible = "['image-a', 'image-b'].map(id => getComputedStyle(document.getElementById(id)).visibility).join(' ')";
    let hidden = "getComputedStyle(document.getElementById('pane-b')).visibility + ' ' + getComputedStyle(document.getElementById('image-a')).visibility";
    browser.click("button[data-mode=flip]");
    assert_eq!(browser.value(hidden), "hidden visible");
    browser.click("#flip");
    assert_eq!(browser.value(hidden), "visible hidden");
    browser.value("document.getElementById('stage').focus()");
    browser.press("f");
    assert_eq!(browser.value(hidden), "hidden visible");
    browser.click("button[data-mode=side]");
    assert_eq!(browser.value(visible), "visible visible");
    let apart = browser.value("document.getElementById('pane-b').getBoundingClientRect().left >= document.getElementById('pane-a').getBoundingClientRect().right");
    assert_eq!(apart, true);
    // The baseline against the reference comes first; false colours replace what has an error.
    let sources = "['image-a', 'image-b'].map(id => document.getElementById(id).src.slice(-80))";
    let before = browser.value(sources);
    browser.click("#error");
    let after = browser.value(sources);
    assert!(before[0] != after[0] && before[1] == after[1]);
    assert_eq!(browser.value("document.getElementById('name-a').textContent"), "A: asvgf");
    assert_eq!(browser.value("document.getElementById('name-b').textContent"), "B: reference");
    // Another view keeps the variants.
    browser.value("(() => { const v = document.getElementById('view'); v.value = '1'; v.dispatchEvent(new Event('change')); })()");
    assert_eq!(browser.value("document.getElementById('name-a').textContent"), "A: asvgf");
    assert_ne!(browser.value(sources), after);
}

fn series_can_be_hidden(browser: &mut Browser) {
    let shown = "[...document.querySelectorAll('#frames-0 polyline[stroke=\"#0072B2\"]')].filter(e => e.getBoundingClientRect().width > 0).length";
    assert_eq!(browser.value(shown), 2, "a curve in each of two panels");
    browser.click("#frames-0 button[data-color='#0072B2']");
    assert_eq!(browser.value(shown), 0);
    browser.click("#frames-0 button[data-color='#0072B2']");
    assert_eq!(browser.value(shown), 2);
}

fn commands_are_copied(browser: &mut Browser) {
    browser.click("#reproduce .command .copy");
    browser.until("document.getElementById('status').textContent !== ''");
    let text = browser
        .value("document.getElementById('status').textContent === 'Copied' || getSelection().toString()");
    assert!(text == true || text == "pt study studies/denoiser.toml -o out/denoiser", "{text}");
}

fn the_keyboard_reaches_everything(browser: &mut Browser) {
    // Each control is reached by Tab, in the order of the page, and is seen to have the focus.
    let wanted = browser.value(
        "window.controls = [...document.querySelectorAll('a[href], button, select, input, summary, [tabindex=\"0\"]')]\
         .filter(e => !e.disabled && e.checkVisibility()), window.controls.length",
    );
    browser.value("document.activeElement.blur(), getSelection().removeAllRanges()");
    for number in 0..wanted.as_u64().unwrap() {
        browser.press("Tab");
        let state = browser.value(
            "(() => { const e = document.activeElement, s = getComputedStyle(e); \
             return [window.controls.indexOf(e), s.outlineStyle !== 'none' && parseFloat(s.outlineWidth) > 0, e.outerHTML.slice(0, 80)]; })()",
        );
        assert_eq!(state[0], number, "{state}");
        assert_eq!(state[1], true, "{state} shows no focus");
    }
    // Every control has a name that is read aloud.
    let nameless = browser.value(
        "window.controls.filter(e => !(e.textContent.trim() || e.getAttribute('aria-label') || e.labels?.length)).map(e => e.outerHTML)",
    );
    assert_eq!(nameless, serde_json::json!([]));
}

fn themes_and_widths(browser: &mut Browser, page: &Path) {
    let dark = "(() => { const c = getComputedStyle(document.body).backgroundColor.match(/\\d+/g).map(Number); return c[0] + c[1] + c[2] < 200; })()";
    let screenshots = std::env::var_os("PT_SCREENSHOTS").map(std::path::PathBuf::from);
    for theme in ["dark", "light"] {
        browser.prefer(theme);
        for width in [1280, 420] {
            browser.open(page, width, 900);
            assert_eq!(browser.value(dark), theme == "dark");
            let room = browser.value("[document.documentElement.scrollWidth, innerWidth]");
            assert!(room[0].as_u64() <= room[1].as_u64(), "{width} pixels: the page is {room} wide");
            if width == 1280 {
                let hidden = browser.value("[...document.querySelectorAll('.answer .scroll')].map(e => e.scrollWidth - e.clientWidth)");
                assert_eq!(
                    hidden,
                    serde_json::json!([0, 0, 0]),
                    "parts of the answer that are seen only by scrolling"
                );
            }
            if let Some(folder) = &screenshots {
                browser.until("[...document.querySelectorAll('#stage img')].every(image => image.complete)");
                browser.screenshot(&folder.join(format!("report-{theme}-{width}.png")));
            }
        }
    }
    // The switch of the page overrides the system.
    browser.click("#theme");
    browser.click("#theme");
    assert_eq!(browser.value("document.getElementById('theme').textContent"), "Theme: dark");
    assert_eq!(browser.value(dark), true);
}

fn nothing_is_requested_or_reported(browser: &Browser) {
    for event in &browser.events {
        let parameters = &event["params"];
        match event["method"].as_str().unwrap_or_default() {
            "Runtime.consoleAPICalled" | "Runtime.exceptionThrown" | "Log.entryAdded" => {
                panic!("console: {parameters}")
            }
            "Network.requestWillBeSent" => {
                let url = parameters["request"]["url"].as_str().unwrap();
                assert!(url.starts_with("file://") || url.starts_with("data:"), "requests {url}");
            }
            _ => {}
        }
    }
}
