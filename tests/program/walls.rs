//! The walls of the layout: which crate may depend on which, and no circle among the files of a crate.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use proc_macro2::{TokenStream, TokenTree};
use quote::ToTokens;
use serde_json::Value;
use syn::{Attribute, Item, UseTree, Visibility};

/// What nothing depends on but tests, and the Python package on the program's library.
const UPPERMOST: [&str; 3] = ["planesman", "planesman_python", "planesman_testing"];
const REPORTS: [&str; 3] = ["planesman_book", "brunner_1988", "ibm_1966"];
const NODES: [&str; 5] = [
    "depth_controller",
    "dha_actuator",
    "plant_sim",
    "recorder",
    "sysid",
];

/// A member of the workspace: its folder, and what it depends on apart from its tests.
struct Member {
    folder: PathBuf,
    dependencies: Vec<String>,
}

fn members() -> BTreeMap<String, Member> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = Command::new(env!("CARGO"))
        .args([
            "metadata",
            "--no-deps",
            "--offline",
            "--format-version",
            "1",
        ])
        .current_dir(root)
        .output()
        .expect("cargo runs");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let text = |value: &Value| value.as_str().expect("text").to_owned();
    let member = |package: &Value| {
        let manifest = PathBuf::from(text(&package["manifest_path"]));
        let folder = manifest.parent().and_then(|it| it.strip_prefix(root).ok());
        let dependencies = package["dependencies"].as_array().expect("a list");
        let dependencies = dependencies.iter().filter(|it| it["kind"] != "dev");
        let member = Member {
            folder: folder.expect("a folder of the workspace").to_owned(),
            dependencies: dependencies.map(|it| text(&it["name"])).collect(),
        };
        (text(&package["name"]), member)
    };
    let packages = metadata["packages"].as_array().expect("a list");
    packages.iter().map(member).collect()
}

/// What a crate depends on, directly or through other members.
fn reach<'a>(members: &'a BTreeMap<String, Member>, name: &'a str) -> BTreeSet<&'a str> {
    let mut reached = BTreeSet::new();
    let mut open = vec![name];
    while let Some(member) = open.pop().and_then(|name| members.get(name)) {
        let new = member.dependencies.iter().map(String::as_str);
        open.extend(new.filter(|it| reached.insert(*it)));
        open.retain(|it| members.contains_key(*it));
    }
    reached
}

#[test]
fn no_crate_reaches_over_the_walls() {
    let members = members();
    for (name, member) in &members {
        let folder = member.folder.iter().next().and_then(|it| it.to_str());
        let forbidden: &[&[&str]] = match folder {
            Some("msgs" | "crates" | "nodes") => &[&UPPERMOST, &REPORTS, &NODES],
            // The Python package is the program's library for others.
            Some("python") => &[&["planesman_testing"]],
            _ => &[&UPPERMOST],
        };
        let reached = reach(&members, name);
        let found = forbidden
            .concat()
            .into_iter()
            .find(|it| reached.contains(it));
        assert_eq!(found, None, "{name} depends on it");
    }
}

#[test]
fn identification_knows_no_file_no_message_and_no_command_line() {
    let members = members();
    let reached = reach(&members, "planesman_identification");
    let own = reached.into_iter().filter(|it| members.contains_key(*it));
    assert_eq!(
        own.collect::<Vec<_>>(),
        ["planesman_linear", "planesman_parallel", "planesman_pitch"]
    );
    let direct = &members["planesman_identification"].dependencies;
    assert!(
        !direct
            .iter()
            .any(|it| ["clap", "csv", "mcap", "serde_json", "anyhow"].contains(&it.as_str()))
    );
}

#[test]
fn the_files_of_a_crate_form_no_circle() {
    let mut circles = Vec::new();
    for member in members().values() {
        let root = member.folder.join("src/lib.rs");
        if root.is_file() {
            let circle = circle(&Sources::read(&root).edges());
            circles.extend(circle.map(|it| format!("{}: {it:?}", member.folder.display())));
        }
    }
    assert!(circles.is_empty(), "{}", circles.join("\n"));
}

/// Files that lead back to the first of them, if there are any.
fn circle(edges: &BTreeMap<String, BTreeSet<String>>) -> Option<Vec<String>> {
    let mut edges = edges.clone();
    // A file that names none of those left is in no circle.
    loop {
        let left: BTreeSet<_> = edges.keys().cloned().collect();
        edges.retain(|_, named| {
            named.retain(|it| left.contains(it));
            !named.is_empty()
        });
        if edges.len() == left.len() {
            break;
        }
    }
    let mut path = vec![edges.keys().next()?.clone()];
    loop {
        let next = edges[path.last()?].first()?;
        if let Some(start) = path.iter().position(|it| it == next) {
            return Some(path.split_off(start));
        }
        path.push(next.clone());
    }
}

/// A path of Rust, `["sensors", "gyro"]`; from the root of the crate where it names a module.
type RustPath = Vec<String>;

/// A module in a file of its own, its tests left out.
#[derive(Default)]
struct Source {
    /// What it takes in under a name: with `pub` a re-export.
    imports: BTreeMap<String, RustPath>,
    /// What it uses itself.
    used: Vec<RustPath>,
}

/// The files of one crate.
#[derive(Default)]
struct Sources(BTreeMap<RustPath, Source>);

impl Sources {
    fn read(root: &Path) -> Self {
        let mut sources = Self::default();
        sources.add(root, root.parent().expect("a folder"), Vec::new());
        sources
    }

    /// Adds a file, and those of its modules in `folder`.
    fn add(&mut self, file: &Path, folder: &Path, module: RustPath) {
        let text = fs::read_to_string(file).expect("a source file");
        let items = syn::parse_file(&text).expect("Rust").items;
        let mut source = Source::default();
        for item in items.iter().filter(|it| !is_test(it)) {
            match item {
                Item::Mod(child) if child.content.is_none() => {
                    let name = child.ident.to_string();
                    let inner = folder.join(&name);
                    let file = [inner.with_extension("rs"), inner.join("mod.rs")];
                    let file = file
                        .iter()
                        .find(|it| it.is_file())
                        .expect("the module's file");
                    self.add(file, &inner, [module.clone(), vec![name]].concat());
                }
                Item::Use(import) => {
                    let mut names = Vec::new();
                    flatten(&import.tree, &mut Vec::new(), &mut names);
                    if matches!(import.vis, Visibility::Inherited) {
                        source
                            .used
                            .extend(names.iter().map(|(_, path)| path.clone()));
                    }
                    source.imports.extend(names);
                }
                other => paths(other.to_token_stream(), &mut source.used),
            }
        }
        self.0.insert(module, source);
    }

    /// Which file uses which.
    fn edges(&self) -> BTreeMap<String, BTreeSet<String>> {
        let edge = |(module, source): (&RustPath, &Source)| {
            let used = source
                .used
                .iter()
                .filter_map(|path| self.home(module, path));
            let used = used.filter(|it| it != module).map(|it| it.join("::"));
            (module.join("::"), used.collect())
        };
        self.0.iter().map(edge).collect()
    }

    /// The file where the thing stands that `path` names in `module`; none where it is another crate's.
    fn home(&self, module: &[String], path: &[String]) -> Option<RustPath> {
        let mut home = module.to_vec();
        let mut rest = path;
        while let [first, more @ ..] = rest {
            match first.as_str() {
                "crate" => home.clear(),
                "super" => drop(home.pop()?),
                "self" => {}
                _ => break,
            }
            rest = more;
        }
        let is_local = rest.len() < path.len();
        for (i, name) in rest.iter().enumerate() {
            let child = [home.clone(), vec![name.clone()]].concat();
            if self.0.contains_key(&child) {
                home = child;
                continue;
            }
            return match self.0[&home].imports.get(name) {
                Some(target) if is_local || i > 0 => self.home(&home, target),
                _ => (is_local || i > 0).then_some(home),
            };
        }
        Some(home)
    }
}

fn is_test(item: &Item) -> bool {
    let attributes: &[Attribute] = match item {
        Item::Mod(it) => &it.attrs,
        Item::Use(it) => &it.attrs,
        Item::Fn(it) => &it.attrs,
        Item::Impl(it) => &it.attrs,
        Item::Const(it) => &it.attrs,
        _ => &[],
    };
    let is_test =
        |it: &Attribute| it.to_token_stream().to_string().replace(' ', "") == "#[cfg(test)]";
    attributes.iter().any(is_test)
}

/// The names that a `use` takes in, each with its path.
fn flatten(tree: &UseTree, prefix: &mut RustPath, names: &mut Vec<(String, RustPath)>) {
    let mut name = |own: &syn::Ident, shown: &syn::Ident| {
        let own = own.to_string();
        let path = [prefix.clone(), vec![own.clone()]].concat();
        match own.as_str() {
            "self" => names.push((prefix.last().cloned().unwrap_or_default(), prefix.clone())),
            _ => names.push((shown.to_string(), path)),
        }
    };
    match tree {
        UseTree::Name(it) => name(&it.ident, &it.ident),
        UseTree::Rename(it) => name(&it.ident, &it.rename),
        UseTree::Path(it) => {
            prefix.push(it.ident.to_string());
            flatten(&it.tree, prefix, names);
            prefix.pop();
        }
        UseTree::Group(it) => it.items.iter().for_each(|it| flatten(it, prefix, names)),
        UseTree::Glob(_) => names.push(("*".to_owned(), prefix.clone())),
    }
}

/// Adds every path of two names and more, `a::b`, in these tokens.
fn paths(tokens: TokenStream, found: &mut Vec<RustPath>) {
    let mut path = RustPath::new();
    let mut colons = 0;
    for token in tokens {
        match &token {
            TokenTree::Punct(it) if it.as_char() == ':' => colons += 1,
            TokenTree::Ident(it) if colons == 2 && !path.is_empty() => {
                path.push(it.to_string());
                colons = 0;
            }
            _ => {
                found.extend((path.len() > 1).then(|| std::mem::take(&mut path)));
                path.clear();
                colons = 0;
                match token {
                    TokenTree::Ident(it) => path.push(it.to_string()),
                    TokenTree::Group(it) => paths(it.stream(), found),
                    _ => {}
                }
            }
        }
    }
    found.extend((path.len() > 1).then_some(path));
}
