//! A picture that belongs to a table.

/// An SVG drawing; `oxplow bench` writes it beside the table and links it from Markdown.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Name of its file, without ending.
    pub name: String,
    /// What it shows, in one line.
    pub caption: String,
    /// The whole file.
    pub svg: String,
}

impl Picture {
    /// A picture from its drawing.
    pub fn new(name: &str, caption: &str, svg: String) -> Self {
        Self { name: name.to_owned(), caption: caption.to_owned(), svg }
    }

    /// Name of its file.
    pub fn file_name(&self) -> String {
        format!("{}.svg", self.name)
    }

    /// A link to its file in a folder, as Markdown; the empty folder is that of the page.
    pub fn markdown(&self, folder: &str) -> String {
        let slash = if folder.is_empty() { "" } else { "/" };
        format!("![{}]({folder}{slash}{})\n", self.caption, self.file_name())
    }
}
