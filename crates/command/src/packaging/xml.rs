//! XML writer for the description and the manifests: elements with attributes, indented by two spaces.

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use std::io;

pub(super) type Xml = Writer<Vec<u8>>;
pub(super) type Attributes = Vec<(&'static str, String)>;

/// Returns a document: the declaration, the output of `root`, and a line feed at the end.
pub(super) fn document(root: impl FnOnce(&mut Xml) -> io::Result<()>) -> String {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))
        .and_then(|()| root(&mut xml))
        .expect("writing to memory does not fail");
    let mut text = String::from_utf8(xml.into_inner()).expect("the writer is fed with strings");
    text.push('\n');
    text
}

/// Writes an element without children.
pub(super) fn leaf(xml: &mut Xml, name: &str, attributes: &Attributes) -> io::Result<()> {
    element(xml, name, attributes).write_empty().map(|_| ())
}

/// Writes an element that contains the output of `children`.
pub(super) fn nest(
    xml: &mut Xml,
    name: &str,
    attributes: &Attributes,
    children: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> io::Result<()> {
    element(xml, name, attributes).write_inner_content(children).map(|_| ())
}

fn element<'a>(
    xml: &'a mut Xml,
    name: &'a str,
    attributes: &'a Attributes,
) -> quick_xml::writer::ElementWriter<'a, Vec<u8>> {
    xml.create_element(name).with_attributes(attributes.iter().map(|(key, value)| (*key, value.as_str())))
}

/// Shortest text from which the same number is read back, with an exponent if this is shorter: `1e30`, not thirty
/// zeros.
pub(super) fn real(value: f64) -> String {
    assert!(value.is_finite(), "the standard has no infinite or undefined numbers in a description");
    format!("{value:?}")
}
