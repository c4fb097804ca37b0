//! The page: whole, escaped, and sufficient to itself.

use super::plot::assert_balanced;
use octolux::report::page::{Block, Cell, Image, Page, Picker, Section, Table, base64};
use octolux::report::plot::{Curve, Plot, Scale};

#[test]
fn base64_has_the_vectors_of_rfc_4648() {
    let vectors =
        [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")];
    for (plain, coded) in vectors {
        assert_eq!(base64(plain.as_bytes()), coded);
    }
    assert_eq!(base64(&[0xff, 0xef, 0xbe]), "/+++");
}

fn page() -> Page {
    let plot =
        Plot::new("P", ("x", Scale::Linear), ("y", Scale::Linear)).curve(Curve::line("c", [(0.0, 1.0), (1.0, 2.0)]));
    let table = Table::new(["name", "value"]).captioned("<caption>").row([Cell::from("a & b"), Cell::flagged("−1.5")]);
    let image = |name: &str| Image { name: name.into(), caption: "\"c\"".into(), png: vec![1, 2, 3] };
    let names = vec!["one".to_owned(), "two".to_owned()];
    let section = Section::new("S <1>")
        .with(Block::prose("a < b"))
        .with(Block::Warning("careful".into()))
        .with(Block::Code("octolux --help".into()))
        .with(Block::Plots(vec![plot]))
        .with(Block::Table(table))
        .with(Block::Images(vec![image("one"), image("two")]))
        .with(Block::Picker(Picker { names, left: "one".into(), right: "two".into() }));
    Page::new("T & t").lead("l").section(section)
}

#[test]
fn a_page_is_escaped_and_closed() {
    let html = page().html();
    let body = &html[html.find("<body>").unwrap()..html.find("<script>").unwrap()];
    // Elements that HTML leaves open are closed here to count the others.
    let mut closed = body.to_owned() + "</body>";
    for void in ["<img ", "<input ", "<br"] {
        closed = closed.split(void).enumerate().fold(String::new(), |all, (i, part)| {
            if i == 0 { part.to_owned() } else { all + void + &part.replacen('>', "/>", 1) }
        });
    }
    assert_balanced(&closed);
    assert!(body.contains("a &amp; b") && body.contains("S &lt;1&gt;") && body.contains("a &lt; b"));
    assert!(body.contains("class=\"number flagged\""));
}

#[test]
fn a_page_fetches_nothing() {
    let html = page().html();
    assert!(html.contains("default-src 'none'"));
    let without_namespace = html.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for address in ["http:", "https:", "//cdn", "@import", "url("] {
        assert!(!without_namespace.contains(address), "{address}");
    }
    let sources: Vec<_> = html.split("src=\"").skip(1).collect();
    assert_eq!(sources.len(), 2);
    assert!(sources.iter().all(|s| s.starts_with("data:image/png;base64,AQID\"")));
}
