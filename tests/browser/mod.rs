//! A page in headless Chromium: what its script drew, and what it tells under the cursor.

// Each test program uses its own part.
#![allow(dead_code)]

use std::path::Path;
use std::process::Command;

#[path = "../foreign/peers.rs"]
mod peers;

/// A page as the browser shows it.
pub(crate) struct Seen {
    /// Of each plot its heading, and what its legend says with the cursor over it.
    pub(crate) plots: Vec<(String, String)>,
    /// Errors of its scripts.
    pub(crate) errors: Vec<String>,
    /// The document as it is after its scripts ran.
    pub(crate) document: String,
}

/// Collects errors from the first script on.
const HEAD: &str = "<head><script>const errors = [];
addEventListener('error', (event) => errors.push(event.message));
const complain = console.error; console.error = (...it) => { errors.push(it.join(' ')); complain(...it); };</script>";

/// Moves the cursor over each plot until it tells something that it does not tell without, and writes all down.
const PROBE: &str = r#"<script>addEventListener("load", () => setTimeout(() => {
dispatchEvent(new Event("beforeprint"));
dispatchEvent(new Event("afterprint"));
setTimeout(() => {
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
  lines.push(...errors.map((it) => `error\t${it}`));
  const it = document.createElement("pre");
  it.id = "seen";
  it.textContent = lines.join("\n");
  document.body.append(it);
}, 300);
}, 300));</script></body>"#;

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

/// Checks that the plots of the page are printed as lines, and not as pictures of the screen's resolution.
pub(crate) fn assert_prints_lines(page: &Path) {
    let folder = tempfile::tempdir().expect("a folder");
    let print = folder.path().join("page.pdf");
    let run = chromium(folder.path())
        .arg(format!("--print-to-pdf={}", print.display()))
        .arg(format!("file://{}", page.display()))
        .output();
    if run.is_err() {
        return peers::skip("there is no chromium");
    }
    let print = std::fs::read(print).expect("a PDF");
    let has = |part: &[u8]| print.windows(part.len()).any(|it| it == part);
    assert!(has(b"/Type /Page\n"), "{}: no page", page.display());
    assert!(
        !has(b"/Subtype /Image"),
        "{}: a plot is printed as a picture",
        page.display()
    );
}

/// The page in Chromium; `None`, having said so, where there is none.
pub(crate) fn look(page: &Path) -> Option<Seen> {
    let text = std::fs::read_to_string(page).expect("a page");
    let folder = tempfile::tempdir().expect("a folder");
    let probed = folder.path().join("page.html");
    let text = text.replacen("<head>", HEAD, 1);
    let end = text.rfind("</body>").expect("a whole page");
    let text = format!("{}{PROBE}{}", &text[..end], &text[end + "</body>".len()..]);
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
    let (mut plots, mut errors) = (Vec::new(), Vec::new());
    for line in lines {
        match line.split('\t').collect::<Vec<_>>()[..] {
            ["plot", heading, told] => plots.push((heading.to_owned(), told.to_owned())),
            _ => errors.push(line.to_owned()),
        }
    }
    Some(Seen {
        plots,
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
