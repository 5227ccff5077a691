//! The lossless tree, for callers that must keep comments.

use super::{Flaw, Pdl, Position, Sink, SyntaxKind, SyntaxNode, parse_into};
use rowan::{GreenNodeBuilder, Language};

/// Returns the tree of `text`, which contains the whole text. Never fails: the reader reports flaws.
pub(crate) fn parse(text: &str) -> SyntaxNode {
    tree(text).0
}

fn tree(text: &str) -> (SyntaxNode, Vec<Flaw>) {
    let (mut tree, flaws) = parse_into(text, Tree::new);
    tree.green.finish_node();
    (SyntaxNode::new_root(tree.green.finish()), flaws)
}

struct Tree {
    green: GreenNodeBuilder<'static>,
}

impl Tree {
    fn new() -> Tree {
        let mut green = GreenNodeBuilder::new();
        green.start_node(Pdl::kind_to_raw(SyntaxKind::Root));
        Tree { green }
    }
}

impl Sink<'_> for Tree {
    fn open(&mut self, kind: SyntaxKind, _: Position) {
        self.green.start_node(Pdl::kind_to_raw(kind));
    }

    fn token(&mut self, kind: SyntaxKind, text: &str, _: Position) {
        self.green.token(Pdl::kind_to_raw(kind), text);
    }

    fn close(&mut self) {
        self.green.finish_node();
    }
}

#[cfg(test)]
mod tests {
    use super::{super::FlawKind, tree};

    fn lossless(text: &str) -> Vec<FlawKind> {
        let (root, flaws) = tree(text);
        assert_eq!(root.text().to_string(), text);
        flaws.into_iter().map(|flaw| flaw.kind).collect()
    }

    #[test]
    fn every_text_has_a_tree_with_the_same_text() {
        assert_eq!(lossless("(a #| x #| y |# |# 'b ; c\n \"s\\\"\")"), []);
        assert_eq!(lossless("a))"), [FlawKind::UnmatchedClose, FlawKind::UnmatchedClose]);
        assert_eq!(lossless("(a ')"), [FlawKind::DanglingPrefix]);
        assert_eq!(lossless("\"abc"), [FlawKind::UnclosedText]);
    }

    #[test]
    fn an_unclosed_form_ends_where_the_next_one_starts_in_the_first_column() {
        let text = "(a (b\n  (c))\n(d)\n(e)";
        assert_eq!(lossless(text), [FlawKind::UnclosedList { suspect: Some(3), next: Some(13) }]);
        assert_eq!(lossless("(a\n(d))"), []);
    }

    #[test]
    fn depth_is_limited_once() {
        let text = "(".repeat(1000) + &")".repeat(1000);
        assert_eq!(lossless(&text), [FlawKind::TooDeep]);
    }
}
