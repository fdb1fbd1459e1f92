//! The data directory: where everything lies, and how a file comes into being whole or not at all.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Files younger than this may belong to an upload that is still going on in another process.
const LITTER_AGE: Duration = Duration::from_secs(3600);

/// Paths inside a data directory. Ids and keys are lowercase hex, made here and never by a client.
#[derive(Clone, Debug)]
pub struct DataDir {
    root: PathBuf,
}

impl DataDir {
    /// Opens a data directory, creating what is missing.
    ///
    /// # Errors
    /// When a folder cannot be created.
    pub fn open(root: &Path) -> io::Result<Self> {
        let data = Self { root: root.to_owned() };
        for folder in [data.outfits(), data.statics(), data.bakes(), data.heroes(), data.thumbnails()] {
            std::fs::create_dir_all(folder)?;
        }
        Ok(data)
    }

    /// The SQLite database.
    pub fn database(&self) -> PathBuf {
        self.root.join("toile.sqlite3")
    }

    /// Folder of uploaded files.
    pub fn outfits(&self) -> PathBuf {
        self.root.join("outfits")
    }

    /// Folder of static passes.
    pub fn statics(&self) -> PathBuf {
        self.root.join("static")
    }

    /// Folder of bakes.
    pub fn bakes(&self) -> PathBuf {
        self.root.join("bakes")
    }

    /// Folder of pixel-cloth networks.
    pub fn heroes(&self) -> PathBuf {
        self.root.join("heroes")
    }

    /// Folder of thumbnails.
    pub fn thumbnails(&self) -> PathBuf {
        self.root.join("thumbnails")
    }

    /// The uploaded file of an outfit.
    pub fn outfit(&self, id: &str) -> PathBuf {
        self.outfits().join(id)
    }

    /// A static pass, by its key.
    pub fn static_pass(&self, key: &str) -> PathBuf {
        self.statics().join(key)
    }

    /// A bake, by the key of the static pass that it refines.
    pub fn bake(&self, key: &str) -> PathBuf {
        self.bakes().join(key)
    }

    /// The pixel-cloth network of an outfit.
    pub fn hero(&self, id: &str) -> PathBuf {
        self.heroes().join(id)
    }

    /// The picture of an outfit.
    pub fn thumbnail(&self, id: &str) -> PathBuf {
        self.thumbnails().join(format!("{id}.png"))
    }
}

/// Writes a file so that it is there whole or not at all, also after a power cut.
///
/// # Errors
/// When the folder cannot be written; nothing is left behind then.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = path.parent().ok_or_else(|| io::Error::other("a path without a folder"))?;
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    file.persist(path)?;
    std::fs::File::open(folder)?.sync_all()
}

/// Removes a file that may be gone already.
///
/// # Errors
/// When it is there and stays.
pub fn remove_if_present(path: &Path) -> io::Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Removes files of `folder` that `is_wanted` does not know, left by a crash or an older version.
/// Returns how many.
///
/// # Errors
/// When the folder cannot be read or a file cannot be removed.
pub fn sweep(folder: &Path, is_wanted: impl Fn(&str) -> bool) -> io::Result<usize> {
    let mut removed = 0;
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let age = SystemTime::now().duration_since(entry.metadata()?.modified()?).unwrap_or_default();
        if age > LITTER_AGE && !is_wanted(&entry.file_name().to_string_lossy()) {
            remove_if_present(&entry.path())?;
            removed += 1;
        }
    }
    Ok(removed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_leaves_no_other_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        write_atomically(&path, b"one").unwrap();
        write_atomically(&path, b"two").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn only_old_unknown_files_are_swept() {
        let folder = tempfile::tempdir().unwrap();
        let old = SystemTime::now() - LITTER_AGE * 2;
        for (name, time) in [("known", old), ("litter", old), ("fresh", SystemTime::now())] {
            let file = std::fs::File::create(folder.path().join(name)).unwrap();
            file.set_modified(time).unwrap();
        }
        assert_eq!(sweep(folder.path(), |name| name == "known").unwrap(), 1);
        assert!(!folder.path().join("litter").exists());
        assert!(folder.path().join("fresh").exists());
    }
}
