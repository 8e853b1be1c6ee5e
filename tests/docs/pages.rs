//! Pages of Markdown: headings, fenced blocks, tables and links.

use std::path::{Path, PathBuf};

/// The root of the tree.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).into()
}

/// A page.
pub struct Page {
    pub path: PathBuf,
    pub lines: Vec<String>,
}

/// A fenced block.
pub struct Block {
    /// The line of its fence, from 1.
    pub line: usize,
    /// The words after the fence: the language, and what the block is.
    pub words: Vec<String>,
    pub text: String,
}

/// A row of a table: its line, from 1, and its cells.
pub struct Row {
    pub line: usize,
    pub cells: Vec<String>,
}

/// The README and the pages of `docs/`.
pub fn all() -> Vec<Page> {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(root().join("docs")).unwrap().map(|e| e.unwrap().path()).collect();
    paths.retain(|p| p.extension().is_some_and(|e| e == "md"));
    paths.sort();
    assert!(paths.len() >= 5, "docs/ has {} pages", paths.len());
    paths.push(root().join("README.md"));
    paths.iter().map(|p| Page::read(p)).collect()
}

/// A page of `docs/`.
pub fn page(name: &str) -> Page {
    Page::read(&root().join("docs").join(name))
}

impl Page {
    pub fn read(path: &Path) -> Page {
        let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        Page { path: path.into(), lines: text.lines().map(String::from).collect() }
    }

    pub fn name(&self) -> String {
        self.path.file_name().unwrap().to_string_lossy().into_owned()
    }

    /// A place in it, for messages.
    pub fn at(&self, line: usize) -> String {
        format!("{}:{line}", self.name())
    }

    /// Whether each line stands in a fenced block, fences included.
    fn fenced(&self) -> Vec<bool> {
        let mut open = false;
        let inside = |line: &String| {
            let fence = line.trim_start().starts_with("```");
            open ^= fence;
            open || fence
        };
        self.lines.iter().map(inside).collect()
    }

    /// Lines outside of blocks, with their places from 1.
    pub fn prose(&self) -> Vec<(usize, &str)> {
        let fenced = self.fenced();
        let lines = self.lines.iter().enumerate().filter(|(i, _)| !fenced[*i]);
        lines.map(|(i, line)| (i + 1, line.as_str())).collect()
    }

    pub fn blocks(&self) -> Vec<Block> {
        let mut blocks: Vec<Block> = vec![];
        let mut open = false;
        for (i, line) in self.lines.iter().enumerate() {
            if let Some(words) = line.strip_prefix("```") {
                open = !open;
                if open {
                    let words = words.split_whitespace().map(String::from).collect();
                    blocks.push(Block { line: i + 1, words, text: String::new() });
                }
            } else if open && let Some(block) = blocks.last_mut() {
                block.text += line;
                block.text.push('\n');
            }
        }
        assert!(!open, "{}: a block is not closed", self.name());
        blocks
    }

    /// Headings: line, level, text.
    pub fn headings(&self) -> Vec<(usize, usize, &str)> {
        let heading = |(line, text): (usize, &'_ str)| {
            let level = text.bytes().take_while(|b| *b == b'#').count();
            (level > 0).then_some((line, level))
        };
        let found: Vec<(usize, usize)> = self.prose().into_iter().filter_map(heading).collect();
        found.into_iter().map(|(line, level)| (line, level, self.lines[line - 1][level..].trim())).collect()
    }

    /// The lines of the section under a heading, to the next heading of any level: first, and one after the last, from 1.
    pub fn section(&self, heading: &str) -> [usize; 2] {
        let headings = self.headings();
        let k = headings.iter().position(|h| h.2 == heading);
        let k = k.unwrap_or_else(|| panic!("{} has no heading `{heading}`", self.name()));
        [headings[k].0 + 1, headings.get(k + 1).map_or(self.lines.len() + 1, |h| h.0)]
    }

    /// The rows of the tables between two lines, without their heads.
    pub fn rows(&self, [first, end]: [usize; 2]) -> Vec<Row> {
        let mut rows = vec![];
        let prose = self.prose();
        let within = prose.iter().filter(|(line, _)| (first..end).contains(line));
        for (line, text) in within {
            let cells: Vec<String> = match text.strip_prefix('|') {
                Some(rest) => rest.trim_end().trim_end_matches('|').split('|').map(|c| c.trim().to_string()).collect(),
                None => continue,
            };
            if cells[0].starts_with("---") {
                // The row before this one was the head.
                rows.pop();
            } else {
                rows.push(Row { line: *line, cells });
            }
        }
        rows
    }

    /// Links and images: the line and the target of each.
    pub fn links(&self) -> Vec<(usize, String)> {
        let mut links = vec![];
        for (line, text) in self.prose() {
            let targets = text.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
            links.extend(targets.map(|(target, _)| (line, target.to_string())));
        }
        links
    }

    /// The names by which links find its headings.
    pub fn anchors(&self) -> Vec<String> {
        let slug = |text: &str| {
            let kept =
                text.to_lowercase().chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_')).collect();
            let kept: String = kept;
            kept.replace(' ', "-")
        };
        self.headings().iter().map(|h| slug(h.2)).collect()
    }
}

/// What stands between backticks.
pub fn quoted(text: &str) -> Vec<&str> {
    text.split('`').skip(1).step_by(2).collect()
}

#[test]
fn links_and_images_are_there() {
    let mut n = 0;
    let pages = all().into_iter().chain(["CONTRIBUTING.md", "ARCHITECTURE.md"].map(|p| Page::read(&root().join(p))));
    for page in pages {
        for (line, target) in page.links() {
            if target.starts_with("http") {
                continue;
            }
            let (file, anchor) = target.split_once('#').map_or((target.as_str(), None), |(f, a)| (f, Some(a)));
            let path = if file.is_empty() { page.path.clone() } else { page.path.parent().unwrap().join(file) };
            assert!(path.exists(), "{}: there is no {}", page.at(line), path.display());
            if let Some(anchor) = anchor {
                let anchors = Page::read(&path).anchors();
                assert!(anchors.iter().any(|a| a == anchor), "{}: {target} leads to no heading", page.at(line));
            }
            n += 1;
        }
    }
    assert!(n > 50, "{n} links");
}
