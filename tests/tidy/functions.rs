//! How long the functions of a file are, in lines from `fn` to the closing brace, those within macros included.

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// A function and its length.
#[derive(Debug, PartialEq)]
pub struct Function {
    /// Its name.
    pub name: String,
    /// Line of its `fn`, counted from 1.
    pub line: usize,
    /// Lines from `fn` to the closing brace.
    pub length: usize,
}

/// The functions of a source text that have a body.
pub fn functions(text: &str) -> Vec<Function> {
    let tokens: TokenStream = text.parse().unwrap_or_else(|e| panic!("{e}"));
    let mut found = Vec::new();
    collect(tokens, &mut found);
    found
}

fn collect(tokens: TokenStream, found: &mut Vec<Function>) {
    let mut tokens = tokens.into_iter().peekable();
    // The function whose body is yet to come.
    let mut head: Option<(String, usize)> = None;
    while let Some(token) = tokens.next() {
        match token {
            TokenTree::Ident(word) if word == "fn" => {
                if let Some(TokenTree::Ident(name)) = tokens.peek() {
                    head = Some((name.to_string(), word.span().start().line));
                }
            }
            TokenTree::Punct(mark) if mark.as_char() == ';' => head = None,
            TokenTree::Group(group) => {
                if group.delimiter() == Delimiter::Brace
                    && let Some((name, line)) = head.take()
                {
                    found.push(Function { name, line, length: group.span_close().end().line - line + 1 });
                }
                collect(group.stream(), found);
            }
            TokenTree::Ident(_) | TokenTree::Punct(_) | TokenTree::Literal(_) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_goes_from_fn_to_the_closing_brace() {
        let text = "/// Not fn f() {}.\npub fn a(\n    x: fn(u8) -> u8,\n) {\n    fn b() {\n        \"}\";\n    }\n}\n\
                    trait T {\n    fn c();\n    fn d() {}\n}\nproptest! {\n    fn e(x in 0..1) {\n    }\n}\n";
        let found: Vec<(String, usize, usize)> =
            functions(text).into_iter().map(|f| (f.name, f.line, f.length)).collect();
        let wanted = [("a", 2, 7), ("b", 5, 3), ("d", 11, 1), ("e", 14, 2)].map(|(n, l, k)| (n.to_string(), l, k));
        assert_eq!(found, wanted);
    }
}
