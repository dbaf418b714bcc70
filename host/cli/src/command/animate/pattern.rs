//! File names of an animation, from a pattern such as `frames/light-####.exr`.

use std::path::{Path, PathBuf};

use crate::cli::Usage;

/// Maximum number of digits of a frame's number, which has 32 bits.
const MAX_DIGITS: usize = 10;

/// Pattern of all file names of an animation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    folder: PathBuf,
    head: String,
    digits: usize,
    tail: String,
}

impl Pattern {
    /// Splits a file name at its only run of #.
    pub fn parse(path: &Path) -> Result<Pattern, Usage> {
        let shown = path.display();
        let wrong = |what: &str| Usage(format!("-o {shown}: {what}, as in frames/####.exr"));
        let name = path.file_name().and_then(|name| name.to_str());
        let stem = name.and_then(|name| name.strip_suffix(".exr"));
        let stem = stem.ok_or_else(|| wrong("give the name of EXR files"))?;
        let runs = || wrong("give one run of # where the number of the frame goes");
        let first = stem.find('#').ok_or_else(runs)?;
        let digits = stem[first..].chars().take_while(|&c| c == '#').count();
        let (head, tail) = (&stem[..first], &stem[first + digits..]);
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        if tail.contains('#') || folder.to_string_lossy().contains('#') {
            return Err(runs());
        }
        if digits > MAX_DIGITS {
            let what = format!(
                "there are {digits} # in a row, but a frame's number has at most {MAX_DIGITS} digits"
            );
            return Err(wrong(&what));
        }
        Ok(Pattern { folder, head: head.into(), digits, tail: tail.into() })
    }

    /// Folder of all files.
    pub fn folder(&self) -> &Path {
        if self.folder == Path::new("") { Path::new(".") } else { &self.folder }
    }

    /// Path of a frame's file.
    pub fn frame(&self, frame: u32, extension: &str) -> PathBuf {
        let Pattern { folder, head, digits, tail } = self;
        folder.join(format!("{head}{frame:0digits$}{tail}.{extension}"))
    }

    /// Path of a file of the whole animation.
    pub fn whole(&self, extension: &str) -> PathBuf {
        let name = format!("{}{}", self.head, self.tail);
        let name = name.trim_matches(|c: char| !c.is_alphanumeric());
        self.folder.join(format!("{}.{extension}", if name.is_empty() { "animation" } else { name }))
    }

    /// Paths of all frames, as a format of C's `printf`.
    pub fn printf(&self, extension: &str) -> PathBuf {
        let text = |text: &str| text.replace('%', "%%");
        let folder = PathBuf::from(text(&self.folder().to_string_lossy()));
        let Pattern { head, digits, tail, .. } = self;
        folder.join(format!("{}%0{digits}d{}.{extension}", text(head), text(tail)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_follow_the_pattern() {
        let pattern = Pattern::parse(Path::new("a/light-###_x.exr")).unwrap();
        assert_eq!(pattern.frame(7, "exr"), Path::new("a/light-007_x.exr"));
        assert_eq!(pattern.frame(12_345, "png"), Path::new("a/light-12345_x.png"));
        assert_eq!(pattern.whole("mp4"), Path::new("a/light-_x.mp4"));
        assert_eq!(pattern.printf("png"), Path::new("a/light-%03d_x.png"));
        let bare = Pattern::parse(Path::new("####.exr")).unwrap();
        assert_eq!(
            (bare.frame(0, "exr"), bare.whole("state")),
            ("0000.exr".into(), "animation.state".into())
        );
        assert_eq!(bare.printf("png"), Path::new("./%04d.png"));
        assert_eq!(
            Pattern::parse(Path::new("100%-#.exr")).unwrap().printf("png"),
            Path::new("./100%%-%01d.png")
        );
        assert_eq!(Pattern::parse(Path::new("light-#.exr")).unwrap().whole("mp4"), Path::new("light.mp4"));
        // Widths above 16 bits make the standard library panic.
        for digits in [11, 70_000] {
            let error = Pattern::parse(Path::new(&format!("{}.exr", "#".repeat(digits)))).unwrap_err();
            assert!(error.to_string().contains(&format!("{digits} # in a row")));
        }
        for wrong in ["a.exr", "#a#.exr", "####.png", "####", "#/####.exr", "a/####/", ""] {
            assert!(Pattern::parse(Path::new(wrong)).is_err(), "{wrong}");
        }
    }
}
