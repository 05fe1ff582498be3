//! Output files. Input files of the command are never overwritten, files that Foldwing did not write only with `--force`, and
//! each file is written completely or not at all.
//!
//! The rule and its reasons: `docs/decisions/0006-files-of-the-user.md`.

mod leftover;
mod mark;
mod same;

pub use leftover::Leftover;
pub(super) use leftover::own_signals;
pub use mark::Mark;

use crate::cli::{Failure, print, tell};
use same::Identity;
use std::cell::RefCell;
use std::fs::{self, File};
use std::io::{self, BufWriter, StdoutLock, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use tempfile::NamedTempFile;

/// Prefix of the names of unfinished files.
const UNFINISHED: &str = ".foldwing-";

/// Maximum number of files of one folder that are reported individually.
const MAXIMUM_NAMED: usize = 4;

/// `--force`, the same for every command that writes.
#[derive(Clone, clap::Args)]
pub struct Force {
    /// Overwrite files that were not written by foldwing, but never the inputs of this command
    #[arg(long)]
    pub force: bool,
}

/// `--quiet` of commands whose result goes to standard output.
#[derive(Clone, Copy, clap::Args)]
pub struct Quiet {
    /// Print only the result: no notes, no warnings, no list of the written files
    #[arg(short, long)]
    pub quiet: bool,
}

impl Quiet {
    /// Prints a note, unless `--quiet` suppresses it.
    pub(super) fn note(self, message: &str) {
        if !self.quiet {
            tell::note(message);
        }
    }

    /// Prints a warning, unless `--quiet` suppresses it.
    pub(super) fn warning(self, message: &str) {
        if !self.quiet {
            tell::warning(message);
        }
    }

    /// Prints the result of a command on standard output and the files that it wrote on standard error.
    pub(super) fn print(self, text: &str, outlets: &Outlets) -> Result<(), Failure> {
        let printed = print(text);
        if !self.quiet {
            outlets.report();
        }
        printed
    }
}

/// Inputs and outputs of a command.
pub struct Outlets {
    force: bool,
    read: Vec<(PathBuf, Identity)>,
    written: Vec<PathBuf>,
    finished: Rc<RefCell<Vec<PathBuf>>>,
}

/// Path of an output that may be written, not opened yet.
pub struct Place {
    /// Path given by the user.
    shown: String,
    target: Target,
    mark: Mark,
    force: bool,
    /// Finished files, as given by the user.
    finished: Rc<RefCell<Vec<PathBuf>>>,
}

enum Target {
    /// No output.
    Nothing,
    /// Standard output.
    Standard,
    /// A device or a pipe, which cannot be replaced.
    Stream(PathBuf),
    /// A regular file with links resolved, and the permissions of an existing one.
    File(PathBuf, Option<fs::Permissions>),
}

/// Open output. An existing file is replaced on completion; an unfinished output is discarded.
pub struct Outlet {
    place: Place,
    sink: BufWriter<Sink>,
}

enum Sink {
    Nothing(io::Sink),
    Standard(StdoutLock<'static>),
    Stream(File),
    File(NamedTempFile, Leftover),
}

impl Outlets {
    /// Outputs of a command whose input files are `read`; only regular files among them are protected.
    pub fn new<'a>(force: bool, read: impl IntoIterator<Item = &'a Path>) -> Self {
        let known = |path: &Path| Some((path.to_owned(), Identity::of(path)?));
        Self { force, read: read.into_iter().filter_map(known).collect(), written: Vec::new(), finished: Rc::default() }
    }

    /// Returns the output at a path, with the mark by which an existing file is recognised; `-` is standard output. Creates
    /// missing folders.
    ///
    /// # Errors
    /// The file is an input of this command or already one of its outputs, or a file exists that Foldwing did not write.
    pub fn place(&mut self, path: &Path, mark: Mark) -> Result<Place, Failure> {
        let shown = path.display().to_string();
        let target = self.target(path, &shown, &mark)?;
        if let Target::File(file, _) = &target {
            self.written.push(file.clone());
        }
        Ok(Place { shown, target, mark, force: self.force, finished: Rc::clone(&self.finished) })
    }

    /// The written files, as given by the user.
    pub fn files(&self) -> Vec<String> {
        self.finished.borrow().iter().map(|file| file.display().to_string()).collect()
    }

    /// Prints the written files on standard error; many files of one folder share a line.
    pub fn report(&self) {
        let finished = self.finished.borrow();
        let mut told: Vec<&Path> = Vec::new();
        for file in finished.iter() {
            let folder = file.parent().unwrap_or(Path::new(""));
            let beside: Vec<&PathBuf> = finished.iter().filter(|other| other.parent() == Some(folder)).collect();
            if beside.len() <= MAXIMUM_NAMED {
                eprintln!("wrote {}", file.display());
            } else if !told.contains(&folder) {
                told.push(folder);
                let shown = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
                eprintln!("wrote {} files in {}", beside.len(), shown.display());
            }
        }
    }

    /// Like [`Outlets::place`], for an option that may be missing; without it, nothing is written.
    pub fn place_if(&mut self, path: Option<&Path>, mark: Mark) -> Result<Place, Failure> {
        let finished = Rc::default();
        let nowhere =
            Place { shown: String::new(), target: Target::Nothing, mark: Mark::Never, force: false, finished };
        path.map_or(Ok(nowhere), |path| self.place(path, mark))
    }

    /// Returns the errors of [`Outlets::place`], without registering the path.
    pub fn check(&self, path: &Path, mark: &Mark) -> Result<(), Failure> {
        self.target(path, &path.display().to_string(), mark).map(|_| ())
    }

    fn target(&self, path: &Path, shown: &str, mark: &Mark) -> Result<Target, Failure> {
        if path == Path::new("-") {
            return Ok(Target::Standard);
        }
        let found = fs::metadata(path).ok();
        if path.file_name().is_none()
            || shown.ends_with(['/', '\\'])
            || found.as_ref().is_some_and(fs::Metadata::is_dir)
        {
            return Err(Failure::Files(format!("{shown}: is a folder; name a file in it")));
        }
        if found.as_ref().is_some_and(|found| !found.is_file()) || path.starts_with("/dev") {
            return Ok(Target::Stream(path.to_owned()));
        }
        let file = resolved(path).map_err(|error| Failure::writing(shown, &error))?;
        if let Some((source, _)) = self.read.iter().find(|(_, identity)| Identity::of(&file).as_ref() == Some(identity))
        {
            let source = source.display();
            return Err(Failure::Usage(format!(
                "{shown}: refusing to overwrite an input of this command ({source}); name another file"
            )));
        }
        if self.written.contains(&file) {
            return Err(Failure::Usage(format!(
                "{shown}: two results would be written to this file; name another file \
                                               for one of them"
            )));
        }
        let permissions = found.map(|found| found.permissions());
        if permissions.as_ref().is_some_and(fs::Permissions::readonly) {
            return Err(Failure::Files(format!("{shown}: cannot be written: it is write-protected")));
        }
        if permissions.is_some() && !self.force && !mark.is_on(&file) {
            return Err(stranger(shown, mark));
        }
        Ok(Target::File(file, permissions))
    }
}

/// Error for an existing file that is not recognised as a result of this type.
fn stranger(shown: &str, mark: &Mark) -> Failure {
    let why = match mark {
        Mark::Never => "exists already".to_owned(),
        Mark::Table(_) | Mark::Head { .. } | Mark::Archive { .. } => {
            format!("exists and is not recognised as {}", mark.name())
        }
    };
    Failure::Files(format!("{shown}: {why}; --force overwrites it"))
}

/// Returns the path with links resolved; creates a missing folder.
fn resolved(path: &Path) -> io::Result<PathBuf> {
    if let Ok(file) = fs::canonicalize(path) {
        return Ok(file);
    }
    if fs::symlink_metadata(path).is_ok() {
        return Err(io::Error::new(io::ErrorKind::NotFound, "it is a link to a file that does not exist"));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(folder)?;
    Ok(fs::canonicalize(folder)?.join(path.file_name().unwrap_or_default()))
}

impl Place {
    /// Opens an unfinished file in the same folder.
    pub fn open(self) -> Result<Outlet, Failure> {
        let failed = |error: io::Error| Failure::writing(&self.shown, &error);
        let sink = match &self.target {
            Target::Nothing => Sink::Nothing(io::sink()),
            Target::Standard => Sink::Standard(io::stdout().lock()),
            Target::Stream(path) => Sink::Stream(File::options().write(true).open(path).map_err(failed)?),
            Target::File(path, _) => {
                let folder = path.parent().unwrap_or(Path::new("."));
                let file = unfinished().tempfile_in(folder).map_err(failed)?;
                let leftover = Leftover::watch(file.path());
                Sink::File(file, leftover)
            }
        };
        Ok(Outlet { place: self, sink: BufWriter::new(sink) })
    }

    /// Writes the whole content at once.
    pub fn fill(self, bytes: &[u8]) -> Result<(), Failure> {
        let mut outlet = self.open()?;
        outlet.write_all(bytes).map_err(|error| outlet.failure(&error))?;
        outlet.finish()
    }

    /// Like [`Place::fill`], but flushed to disk before the old file is replaced: for results of long computations.
    pub fn fill_durably(self, bytes: &[u8]) -> Result<(), Failure> {
        let mut outlet = self.open()?;
        outlet.write_all(bytes).and_then(|()| outlet.sync()).map_err(|error| outlet.failure(&error))?;
        outlet.finish()
    }
}

/// Temporary files with the permissions of ordinary files.
#[cfg(unix)]
fn unfinished() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(UNFINISHED).permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
}

#[cfg(not(unix))]
fn unfinished() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(UNFINISHED);
    builder
}

impl Outlet {
    /// Failure for a write error, with the path given by the user.
    pub fn failure(&self, error: &io::Error) -> Failure {
        Failure::writing(&self.place.shown, error)
    }

    /// Path given by the user.
    pub fn name(&self) -> &str {
        &self.place.shown
    }

    fn sync(&mut self) -> io::Result<()> {
        self.sink.flush()?;
        match self.sink.get_ref() {
            Sink::File(file, _) => file.as_file().sync_all(),
            Sink::Nothing(_) | Sink::Standard(_) | Sink::Stream(_) => Ok(()),
        }
    }

    /// Replaces the existing file by the finished one.
    pub fn finish(self) -> Result<(), Failure> {
        let Self { place, sink } = self;
        let failed = |error: &io::Error| Failure::writing(&place.shown, error);
        let mut sink = sink.into_inner().map_err(|error| failed(error.error()))?;
        sink.flush().map_err(|error| failed(&error))?;
        let (Sink::File(file, _leftover), Target::File(path, permissions)) = (sink, &place.target) else {
            return Ok(());
        };
        if permissions.is_none() && path.exists() && !place.force && !place.mark.is_on(path) {
            return Err(stranger(&place.shown, &place.mark)); // it was created in the meantime
        }
        if let Some(permissions) = permissions {
            file.as_file().set_permissions(permissions.clone()).map_err(|error| failed(&error))?;
        }
        file.persist(path).map_err(|error| failed(&error.error))?;
        place.finished.borrow_mut().push(PathBuf::from(&place.shown));
        Ok(())
    }
}

impl Write for Outlet {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.sink.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Nothing(sink) => sink.write(bytes),
            Self::Standard(sink) => sink.write(bytes),
            Self::Stream(sink) => sink.write(bytes),
            Self::File(sink, _) => sink.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Nothing(sink) => sink.flush(),
            Self::Standard(sink) => sink.flush(),
            Self::Stream(sink) => sink.flush(),
            Self::File(sink, _) => sink.flush(),
        }
    }
}
