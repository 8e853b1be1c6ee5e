//! Which file of a crate imports which: the graph of its `use` declarations and paths, read from the source, and its circles.
//!
//! A path counts for the file that defines what it names: re-exports are followed, and the modules on the way do not count. A `mod`
//! declaration is no import; what stands under `#[cfg(test)]` is left out.

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet, HashSet};
use syn::visit::Visit;

/// Source texts by path, with `/` between folders.
pub type Sources = BTreeMap<String, String>;

/// One import: the line it stands in and the path as written.
#[derive(Clone, Debug, PartialEq)]
pub struct Import {
    /// Line of the importing file, counted from 1.
    pub line: usize,
    /// The path as written, without braces.
    pub path: String,
}

/// The first import from each file to each other file.
pub type Imports = BTreeMap<(String, String), Import>;

/// A module of the crate: of a file, or in braces within one.
#[derive(Default)]
struct Module {
    file: String,
    parent: Option<usize>,
    children: BTreeMap<String, usize>,
    /// Names of what it defines.
    items: HashSet<String>,
    /// Names that `use` brings, with the path each stands for.
    aliases: BTreeMap<String, Vec<Vec<String>>>,
    /// Paths before `::*`.
    globs: Vec<Vec<String>>,
    /// The paths that it mentions.
    mentions: Vec<Mention>,
}

/// A path that a module mentions.
struct Mention {
    path: Vec<String>,
    line: usize,
    /// All that a re-exported glob brings.
    all: bool,
}

/// The modules of one crate.
struct Crate<'a> {
    sources: &'a Sources,
    modules: Vec<Module>,
    /// Files of macros that are called by their bare names.
    macros: BTreeMap<String, String>,
}

/// What a path leads to.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Target {
    Module(usize),
    /// A file that defines the name.
    File(String),
}

/// The imports between the files of the crate with this root file.
pub fn imports(sources: &Sources, root: &str) -> Imports {
    let mut all = Crate { sources, modules: Vec::new(), macros: BTreeMap::new() };
    let folder = root.rsplit_once('/').map_or(String::new(), |(folder, _)| format!("{folder}/"));
    all.read_file(root, &folder, None);
    let mut found = Imports::new();
    for (index, module) in all.modules.iter().enumerate() {
        for mention in &module.mentions {
            for file in all.files_of(index, mention) {
                if file != module.file {
                    let import = Import { line: mention.line, path: mention.path.join("::") };
                    found.entry((module.file.clone(), file)).or_insert(import);
                }
            }
        }
    }
    found
}

/// The circles: each set of files of which every one imports, by way of others of the set, every other.
pub fn circles(imports: &Imports) -> Vec<BTreeSet<String>> {
    let reached = |from: &str| {
        let mut seen = BTreeSet::new();
        let mut open = vec![from.to_string()];
        while let Some(file) = open.pop() {
            for (_, to) in imports.keys().filter(|(f, _)| *f == file) {
                if seen.insert(to.clone()) {
                    open.push(to.clone());
                }
            }
        }
        seen
    };
    let files: BTreeSet<&String> = imports.keys().flat_map(|(from, to)| [from, to]).collect();
    let reach: BTreeMap<&String, BTreeSet<String>> = files.iter().map(|f| (*f, reached(f))).collect();
    let mut found: Vec<BTreeSet<String>> = Vec::new();
    for file in files.iter().filter(|f| reach[**f].contains(**f)) {
        let circle = reach[*file].iter().filter(|to| reach[*to].contains(*file)).cloned().collect();
        if !found.contains(&circle) {
            found.push(circle);
        }
    }
    found
}

/// A circle as text: an import a line.
pub fn show(circle: &BTreeSet<String>, imports: &Imports) -> String {
    let within = imports.iter().filter(|((from, to), _)| circle.contains(from) && circle.contains(to));
    within.map(|((from, to), i)| format!("  {from}:{} imports {to} ({})\n", i.line, i.path)).collect()
}

impl Crate<'_> {
    /// Read a file and those of its modules; `folder` is where these lie. Gives the module.
    fn read_file(&mut self, path: &str, folder: &str, parent: Option<usize>) -> usize {
        let text = self.sources.get(path).unwrap_or_else(|| panic!("{path}: no such file"));
        let file = syn::parse_file(text).unwrap_or_else(|e| panic!("{path}:{}: {e}", e.span().start().line));
        self.read_module(&file.items, path, folder, parent)
    }

    fn read_module(&mut self, items: &[syn::Item], file: &str, folder: &str, parent: Option<usize>) -> usize {
        let index = self.modules.len();
        self.modules.push(Module { file: file.to_string(), parent, ..Module::default() });
        for item in items.iter().filter(|i| !of_tests(attributes(i))) {
            self.modules[index].items.extend(names_of(item));
            match item {
                syn::Item::Mod(m) => {
                    let name = m.ident.to_string();
                    let child = match &m.content {
                        Some((_, items)) => self.read_module(items, file, &format!("{folder}{name}/"), Some(index)),
                        None => {
                            let beside = format!("{folder}{name}.rs");
                            let inside = format!("{folder}{name}/mod.rs");
                            let path = if self.sources.contains_key(&beside) { beside } else { inside };
                            self.read_file(&path, &format!("{folder}{name}/"), Some(index))
                        }
                    };
                    self.modules[index].children.insert(name, child);
                }
                _ => {
                    if let syn::Item::Macro(m) = item
                        && let Some(name) = &m.ident
                    {
                        self.macros.insert(name.to_string(), file.to_string());
                    }
                    Reader { module: &mut self.modules[index] }.visit_item(item);
                }
            }
        }
        index
    }

    /// The files that a mention imports.
    fn files_of(&self, module: usize, mention: &Mention) -> BTreeSet<String> {
        let targets = self.resolve(module, &mention.path, &mut HashSet::new());
        let mut files = BTreeSet::new();
        for target in targets {
            match target {
                Target::File(file) => drop(files.insert(file)),
                Target::Module(m) if mention.all => self.all_of(m, &mut files),
                Target::Module(_) => {}
            }
        }
        if let [name] = mention.path.as_slice()
            && let Some(bare) = name.strip_suffix('!')
            && let Some(file) = self.macros.get(bare)
        {
            files.insert(file.clone());
        }
        files
    }

    /// The files of all that a module defines and re-exports, its own modules apart.
    fn all_of(&self, module: usize, files: &mut BTreeSet<String>) {
        let m = &self.modules[module];
        if !m.items.is_empty() {
            files.insert(m.file.clone());
        }
        for path in m.aliases.values().flatten().chain(&m.globs) {
            for target in self.resolve(module, path, &mut HashSet::new()) {
                if let Target::File(file) = target {
                    files.insert(file);
                }
            }
        }
    }

    /// What a path names, seen from a module: nothing where it leads out of the crate.
    fn resolve(&self, module: usize, path: &[String], on_the_way: &mut HashSet<(usize, String)>) -> Vec<Target> {
        let (mut at, mut rest) = (module, path);
        let mut anchored = false;
        while let Some(first) = rest.first() {
            at = match first.as_str() {
                "crate" => 0,
                "self" => at,
                "super" => self.modules[at].parent.unwrap_or(at),
                _ => break,
            };
            anchored = true;
            rest = &rest[1..];
        }
        let mut here = vec![Target::Module(at)];
        for (depth, name) in rest.iter().enumerate() {
            let name = name.trim_end_matches('!');
            let mut next = Vec::new();
            for target in here {
                match target {
                    Target::Module(m) => {
                        let found = self.lookup(m, name, on_the_way);
                        // All that a macro makes is not seen here: the path says where it is.
                        if found.is_empty() && (depth > 0 || anchored) {
                            next.push(Target::File(self.modules[m].file.clone()));
                        }
                        next.extend(found);
                    }
                    // A variant, a constant or a function of the type that was found.
                    Target::File(file) => next.push(Target::File(file)),
                }
            }
            let last = depth + 1 == rest.len();
            if !last && next.iter().any(|t| matches!(t, Target::Module(_))) {
                next.retain(|t| matches!(t, Target::Module(_)));
            }
            here = next;
        }
        here
    }

    /// What a name is within a module.
    fn lookup(&self, module: usize, name: &str, on_the_way: &mut HashSet<(usize, String)>) -> Vec<Target> {
        if !on_the_way.insert((module, name.to_string())) {
            return Vec::new();
        }
        let m = &self.modules[module];
        let mut found = Vec::new();
        if m.items.contains(name) {
            found.push(Target::File(m.file.clone()));
        }
        if let Some(child) = m.children.get(name) {
            found.push(Target::Module(*child));
        }
        for path in m.aliases.get(name).into_iter().flatten() {
            found.extend(self.resolve(module, path, on_the_way));
        }
        if found.is_empty() {
            for glob in &m.globs {
                for target in self.resolve(module, glob, &mut on_the_way.clone()) {
                    if let Target::Module(from) = target {
                        found.extend(self.lookup(from, name, on_the_way));
                    }
                }
            }
        }
        on_the_way.remove(&(module, name.to_string()));
        found
    }
}

/// Collects what an item mentions.
struct Reader<'a> {
    module: &'a mut Module,
}

impl Reader<'_> {
    fn mention(&mut self, path: Vec<String>, line: usize) {
        self.module.mentions.push(Mention { path, line, all: false });
    }

    /// A tree of `use`, with the path before it.
    fn import(&mut self, tree: &syn::UseTree, before: &[String], public: bool) {
        let join = |name: &syn::Ident| [before, &[name.to_string()]].concat();
        match tree {
            syn::UseTree::Path(p) => self.import(&p.tree, &join(&p.ident), public),
            syn::UseTree::Group(g) => g.items.iter().for_each(|t| self.import(t, before, public)),
            syn::UseTree::Name(n) => self.bring(before, &n.ident, &n.ident),
            syn::UseTree::Rename(r) => self.bring(before, &r.ident, &r.rename),
            syn::UseTree::Glob(g) => {
                let line = g.star_token.spans[0].start().line;
                self.module.mentions.push(Mention { path: before.to_vec(), line, all: public });
                self.module.globs.push(before.to_vec());
            }
        }
    }

    fn bring(&mut self, before: &[String], name: &syn::Ident, rename: &syn::Ident) {
        let path = if name == "self" { before.to_vec() } else { [before, &[name.to_string()]].concat() };
        let new = if rename == "self" { before.last().cloned().unwrap_or_default() } else { rename.to_string() };
        self.mention(path.clone(), name.span().start().line);
        self.module.aliases.entry(new).or_default().push(path);
    }

    /// The paths among the tokens of a macro, which may hold anything, and the types that it defines.
    fn tokens(&mut self, tokens: TokenStream) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let colon = |t: Option<&TokenTree>| matches!(t, Some(TokenTree::Punct(p)) if p.as_char() == ':');
        let mut at = 0;
        while let Some(token) = tokens.get(at) {
            at += 1;
            match token {
                TokenTree::Group(group) => self.tokens(group.stream()),
                TokenTree::Ident(first) => {
                    // What a macro defines under a name that is written there.
                    if let Some(TokenTree::Ident(name)) = tokens.get(at)
                        && ["struct", "enum", "trait"].iter().any(|kind| first == kind)
                    {
                        self.module.items.insert(name.to_string());
                    }
                    let mut path = vec![first.to_string()];
                    while colon(tokens.get(at)) && colon(tokens.get(at + 1)) {
                        let Some(TokenTree::Ident(next)) = tokens.get(at + 2) else { break };
                        path.push(next.to_string());
                        at += 3;
                    }
                    let called = match tokens.get(at) {
                        Some(TokenTree::Group(g)) => g.delimiter() == Delimiter::Parenthesis,
                        _ => false,
                    };
                    if matches!(tokens.get(at), Some(TokenTree::Punct(p)) if p.as_char() == '!') {
                        path.last_mut().unwrap().push('!');
                    }
                    if path.len() > 1 || called || path[0].ends_with('!') || is_type(&path[0]) {
                        self.mention(path, first.span().start().line);
                    }
                }
                TokenTree::Punct(_) | TokenTree::Literal(_) => {}
            }
        }
    }
}

impl<'ast> Visit<'ast> for Reader<'_> {
    fn visit_item_use(&mut self, node: &'ast syn::ItemUse) {
        if !of_tests(&node.attrs) && node.leading_colon.is_none() {
            self.import(&node.tree, &[], !matches!(node.vis, syn::Visibility::Inherited));
        }
    }

    fn visit_path(&mut self, node: &'ast syn::Path) {
        if node.leading_colon.is_none()
            && let Some(first) = node.segments.first()
        {
            let path = node.segments.iter().map(|s| s.ident.to_string()).collect();
            self.mention(path, first.ident.span().start().line);
        }
        syn::visit::visit_path(self, node);
    }

    /// A constant in a pattern looks like a variable.
    fn visit_pat_ident(&mut self, node: &'ast syn::PatIdent) {
        if is_type(&node.ident.to_string()) {
            self.mention(vec![node.ident.to_string()], node.ident.span().start().line);
        }
        syn::visit::visit_pat_ident(self, node);
    }

    fn visit_macro(&mut self, node: &'ast syn::Macro) {
        let mut path: Vec<String> = node.path.segments.iter().map(|s| s.ident.to_string()).collect();
        let line = node.path.segments.first().map_or(0, |s| s.ident.span().start().line);
        path.last_mut().unwrap().push('!');
        self.mention(path, line);
        self.tokens(node.tokens.clone());
    }

    fn visit_impl_item_fn(&mut self, node: &'ast syn::ImplItemFn) {
        if !of_tests(&node.attrs) {
            syn::visit::visit_impl_item_fn(self, node);
        }
    }

    fn visit_attribute(&mut self, _: &'ast syn::Attribute) {}

    fn visit_visibility(&mut self, _: &'ast syn::Visibility) {}
}

/// Whether a name is that of a type, a trait, a variant or a constant.
fn is_type(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_uppercase())
}

/// Whether something is compiled for tests alone.
fn of_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|a| match &a.meta {
        syn::Meta::List(list) => list.path.is_ident("cfg") && list.tokens.to_string() == "test",
        other => other.path().is_ident("test"),
    })
}

fn attributes(item: &syn::Item) -> &[syn::Attribute] {
    use syn::Item::*;
    match item {
        Const(i) => &i.attrs,
        Enum(i) => &i.attrs,
        Fn(i) => &i.attrs,
        Impl(i) => &i.attrs,
        Macro(i) => &i.attrs,
        Mod(i) => &i.attrs,
        Static(i) => &i.attrs,
        Struct(i) => &i.attrs,
        Trait(i) => &i.attrs,
        Type(i) => &i.attrs,
        Union(i) => &i.attrs,
        Use(i) => &i.attrs,
        _ => &[],
    }
}

/// The names that an item defines.
fn names_of(item: &syn::Item) -> Option<String> {
    use syn::Item::*;
    let name = match item {
        Const(i) => &i.ident,
        Enum(i) => &i.ident,
        Fn(i) => &i.sig.ident,
        Macro(i) => i.ident.as_ref()?,
        Static(i) => &i.ident,
        Struct(i) => &i.ident,
        Trait(i) => &i.ident,
        Type(i) => &i.ident,
        Union(i) => &i.ident,
        _ => return None,
    };
    Some(name.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crate_of(files: &[(&str, &str)]) -> Sources {
        files.iter().map(|(path, text)| (format!("src/{path}"), text.to_string())).collect()
    }

    /// The imports as `from > to`, without folder and ending.
    fn edges(files: &[(&str, &str)]) -> Vec<String> {
        let stem = |path: &str| path.trim_start_matches("src/").trim_end_matches(".rs").to_string();
        imports(&crate_of(files), "src/lib.rs").keys().map(|(a, b)| format!("{} > {}", stem(a), stem(b))).collect()
    }

    fn circles_of(files: &[(&str, &str)]) -> usize {
        circles(&imports(&crate_of(files), "src/lib.rs")).len()
    }

    #[test]
    fn a_circle_of_three_is_found_and_a_chain_is_none() {
        let circle = [
            ("lib.rs", "mod a; mod b; mod c;"),
            ("a.rs", "use crate::b::B; pub struct A(B);"),
            ("b.rs", "pub struct B; fn f() { crate::c::c() }"),
            ("c.rs", "use super::a::{self, A}; pub fn c() {}"),
        ];
        assert_eq!(edges(&circle), ["a > b", "b > c", "c > a"]);
        let sources = crate_of(&circle);
        let imports = imports(&sources, "src/lib.rs");
        let found = circles(&imports);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].len(), 3);
        assert!(show(&found[0], &imports).contains("src/b.rs:1 imports src/c.rs (crate::c::c)"));
        let mut chain = circle;
        chain[3].1 = "pub fn c() {}";
        assert_eq!(circles_of(&chain), 0);
    }

    #[test]
    fn a_child_that_uses_its_parent_is_in_a_circle_only_if_the_parent_uses_it() {
        let parent = |text| [("lib.rs", "mod a;"), ("a.rs", text), ("a/b.rs", "use super::A; pub fn f(_: A) {}")];
        assert_eq!(circles_of(&parent("mod b; pub struct A;")), 0);
        assert_eq!(circles_of(&parent("mod b; pub struct A; fn g() { b::f(A) }")), 1);
        assert_eq!(circles_of(&parent("mod b; pub struct A; pub use b::f;")), 1);
        assert_eq!(circles_of(&parent("mod b; pub struct A; #[cfg(test)] mod tests { use super::b::f; }")), 0);
    }

    #[test]
    fn re_exports_lead_to_where_a_name_is_defined() {
        let found = edges(&[
            ("lib.rs", "mod state; mod user; mod other; pub use state::Model as M;"),
            ("state.rs", "mod parts; pub use parts::*; pub struct Model;"),
            ("state/parts.rs", "pub struct Part;"),
            ("user.rs", "use crate::M; fn f() -> crate::state::Part { loop {} }"),
            ("other.rs", "use crate::state::*; fn f(_: Part) {}"),
        ]);
        let wanted =
            ["lib > state", "other > state/parts", "state > state/parts", "user > state", "user > state/parts"];
        assert_eq!(found, wanted);
    }

    #[test]
    fn comments_texts_and_other_crates_are_no_imports() {
        let found = edges(&[
            ("lib.rs", "mod a; mod b; mod c;"),
            (
                "a.rs",
                "//! Not crate::b::B.\nuse std::{fmt, b::B};\n// use crate::b::B;\nconst T: &str = \"crate::b::B\";",
            ),
            ("b.rs", "use ::c::C; pub struct B;"),
            ("c.rs", "pub struct C; fn f() { println!(\"{}\", crate::b::B::new()) }"),
        ]);
        assert_eq!(found, ["c > b"]);
    }

    #[test]
    fn macros_count_for_the_file_that_has_them() {
        let found = edges(&[
            ("lib.rs", "#[macro_use] mod a; mod b; mod c;"),
            (
                "a.rs",
                "macro_rules! bare { () => {} } macro_rules! named { () => { crate::c::f() } } pub(crate) use named;",
            ),
            ("b.rs", "bare!(); fn f() { crate::a::named!() }"),
            ("c.rs", "pub fn f() {}"),
        ]);
        assert_eq!(found, ["a > c", "b > a"]);
    }

    #[test]
    fn types_that_macros_make_are_where_they_are_named() {
        let found = edges(&[
            ("lib.rs", "mod a; mod b; mod c; pub use b::*;"),
            (
                "a.rs",
                "macro_rules! with { ($(#[$m:meta])* pub struct $n:ident { }) => { pub struct $n {} } } pub(crate) use with;",
            ),
            ("b.rs", "crate::a::with! { pub struct Made { } }"),
            ("c.rs", "use crate::Made;"),
        ]);
        assert_eq!(found, ["b > a", "c > b", "lib > b"]);
    }

    #[test]
    fn modules_in_braces_belong_to_their_file() {
        let found = edges(&[
            ("lib.rs", "mod a; mod b;"),
            ("a.rs", "mod inner { pub mod deep; use super::X; } struct X;"),
            ("a/inner/deep.rs", "use super::super::X; use crate::b::{c::{d, e}, f};"),
            ("b.rs", "pub mod c { pub fn d() {} pub fn e() {} } pub fn f() {}"),
        ]);
        assert_eq!(found, ["a/inner/deep > a", "a/inner/deep > b"]);
    }
}
