//! A page in headless Chromium: what its script drew, what it tells under the cursor, and whether all people can use it.

// Each test program uses its own part.
#![allow(dead_code)]

use std::path::Path;
use std::process::Command;

use crate::foreign::peers;

/// A page as the browser shows it.
pub(crate) struct Seen {
    /// Of each plot its heading, and what its legend says with the cursor over it.
    pub(crate) plots: Vec<(String, String)>,
    /// Of each plot its heading, and the place of its cursor while the mouse is over the first plot.
    pub(crate) together: Vec<(String, String)>,
    /// Errors of its scripts, and what axe-core finds.
    pub(crate) errors: Vec<String>,
    /// The document as it is after its scripts ran.
    pub(crate) document: String,
}

/// Collects errors from the first script on.
const HEAD: &str = "<head><script>const errors = [];
addEventListener('error', (event) => errors.push(event.message));
const complain = console.error; console.error = (...it) => { errors.push(it.join(' ')); complain(...it); };</script>";

/// Moves the cursor over each plot until it tells something that it does not tell without, has axe-core look through the page, and writes
/// all down.
const PROBE: &str = r#"<script>addEventListener("load", () => setTimeout(() => {
dispatchEvent(new Event("beforeprint"));
dispatchEvent(new Event("afterprint"));
setTimeout(async () => {
  const lines = [];
  for (const figure of document.querySelectorAll("figure.plot")) {
    const [over, legend] = [figure.querySelector(".u-over"), figure.querySelector(".legend")];
    let told = "";
    if (over && figure.querySelector("canvas").width > 0) {
      const { left, top, width, height } = over.getBoundingClientRect();
      const silent = legend.textContent;
      const move = (x, y) => over.dispatchEvent(new MouseEvent("mousemove", { clientX: left + x * width, clientY: top + y * height, bubbles: true }));
      over.dispatchEvent(new MouseEvent("mouseenter"));
      search: for (let x = 0.5; x < 1.5; x += 0.05) for (let y = 0.5; y < 1.5; y += 0.05) {
        move(x % 1, y % 1);
        if (legend.textContent !== silent) { told = legend.innerText.replace(/\s+/g, " "); break search; }
      }
    }
    lines.push(`plot\t${figure.querySelector("h2").textContent}\t${told}`);
  }
  const [first] = document.querySelectorAll("figure.plot .u-over");
  if (first) {
    const { left, top, width, height } = first.getBoundingClientRect();
    first.dispatchEvent(new MouseEvent("mousemove", { clientX: left + 0.6 * width, clientY: top + 0.5 * height, bubbles: true }));
    for (const figure of document.querySelectorAll("figure.plot")) {
      lines.push(`together\t${figure.querySelector("h2").textContent}\t${figure.querySelector(".at")?.textContent ?? ""}`);
    }
  }
  document.querySelectorAll("details").forEach((it) => { it.open = true; });
  for (const name of ["light", "dark"]) {
    if (!window.axe) break;
    theme.set(name);
    const { violations } = await axe.run(document, { runOnly: AXE_TAGS, resultTypes: ["violations"] });
    for (const { id, impact, nodes } of violations) errors.push(`axe, ${name}: ${impact} ${id}: ${nodes.map((it) => it.html.replace(/\s+/g, " ").slice(0, 200)).join(" ")}`);
  }
  lines.push(...errors.map((it) => `error\t${it}`));
  document.getElementById("axe")?.remove();
  const it = document.createElement("pre");
  it.id = "seen";
  it.textContent = lines.join("\n");
  document.body.append(it);
}, 300);
}, 300));</script></body>"#;

/// The rules of axe-core that a page keeps: those of WCAG 2.2 at level AA, and what axe-core's authors think good.
pub(crate) const AXE_TAGS: &str =
    "['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice']";

/// The script of axe-core; `None`, having said so, where it is not installed.
pub(crate) fn axe() -> Option<String> {
    let path = peers::root().join(".venv/share/axe.min.js");
    let script = std::fs::read_to_string(path).ok();
    if script.is_none() {
        peers::skip("there is no axe-core: tests/browser/install.sh");
    }
    script
}

/// Chromium without a screen, with its profile in the folder.
fn chromium(folder: &Path) -> Command {
    let mut command = Command::new("chromium");
    command
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-quic",
        ])
        .args(["--no-first-run", "--disable-background-networking"])
        .args(["--disable-component-update", "--disable-sync"])
        .args(["--window-size=1400,900", "--virtual-time-budget=20000"])
        .arg(format!("--user-data-dir={}", folder.join("user").display()));
    command
}

/// Checks that the plots of the page are printed as lines, and not as pictures of the screen's resolution. How many pages are printed.
pub(crate) fn assert_prints_lines(page: &Path) -> Option<usize> {
    let folder = tempfile::tempdir().expect("a folder");
    let print = folder.path().join("page.pdf");
    let run = chromium(folder.path())
        .arg(format!("--print-to-pdf={}", print.display()))
        .arg(format!("file://{}", page.display()))
        .output();
    if run.is_err() {
        peers::skip("there is no chromium");
        return None;
    }
    let print = std::fs::read(print).expect("a PDF");
    let count = |part: &[u8]| print.windows(part.len()).filter(|it| *it == part).count();
    let pages = count(b"/Type /Page\n");
    assert!(pages > 0, "{}: no page", page.display());
    assert_eq!(
        count(b"/Subtype /Image"),
        0,
        "{}: a plot is printed as a picture",
        page.display()
    );
    Some(pages)
}

/// The page in Chromium; `None`, having said so, where there is none.
pub(crate) fn look(page: &Path) -> Option<Seen> {
    let text = std::fs::read_to_string(page).expect("a page");
    let folder = tempfile::tempdir().expect("a folder");
    let probed = folder.path().join("page.html");
    let axe = axe().map_or_else(String::new, |it| {
        format!("<script id=\"axe\">{it}</script>")
    });
    let text = text.replacen("<head>", &format!("{HEAD}{axe}"), 1);
    let end = text.rfind("</body>").expect("a whole page");
    let probe = PROBE.replace("AXE_TAGS", AXE_TAGS);
    let text = format!("{}{probe}{}", &text[..end], &text[end + "</body>".len()..]);
    std::fs::write(&probed, text).expect("written");
    let run = chromium(folder.path())
        .arg("--dump-dom")
        .arg(format!("file://{}", probed.display()))
        .output();
    let Ok(run) = run else {
        peers::skip("there is no chromium");
        return None;
    };
    let document = String::from_utf8_lossy(&run.stdout).into_owned();
    let (_, seen) = document
        .rsplit_once("<pre id=\"seen\">")
        .unwrap_or_else(|| {
            let complaint = String::from_utf8_lossy(&run.stderr);
            panic!("chromium shows nothing: {complaint}")
        });
    let lines = seen.split("</pre>").next().unwrap_or_default().lines();
    let (mut plots, mut together, mut errors) = (Vec::new(), Vec::new(), Vec::new());
    for line in lines {
        match line.split('\t').collect::<Vec<_>>()[..] {
            ["plot", heading, told] => plots.push((heading.to_owned(), told.to_owned())),
            ["together", heading, place] => together.push((heading.to_owned(), place.to_owned())),
            _ => errors.push(line.to_owned()),
        }
    }
    Some(Seen {
        plots,
        together,
        errors,
        document,
    })
}

/// Checks that the page draws so many plots, that each tells a value, and that no script fails.
pub(crate) fn assert_alive(page: &Path, plots: usize) -> Option<Seen> {
    let seen = look(page)?;
    assert!(
        seen.errors.is_empty(),
        "{}: {:?}",
        page.display(),
        seen.errors
    );
    assert_eq!(seen.plots.len(), plots, "{}", page.display());
    for (heading, told) in &seen.plots {
        let tells = told.chars().any(|it| it.is_ascii_digit());
        assert!(tells, "{}: '{heading}' tells '{told}'", page.display());
    }
    Some(seen)
}
