//! Bounded reading of files from any source. Only regular files are read: whole, or refused, so that no read blocks
//! forever.
//!
//! Every reader of the program goes through [`open`], [`read_file`], [`read_head`] or [`read_text`]. The exceptions are
//! `memory` and `machine`, which read the system's own files.

use std::fs::{File, Metadata, OpenOptions};
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

use crate::memory;

/// Size from which a file is compared with the available memory (bytes).
const LARGE: u64 = 1 << 24;

/// Returns the bytes of a regular file. Pipes, devices and files that the system generates on reading are refused, since
/// they may never end. A file larger than the available memory is refused too.
///
/// # Errors
///
/// If the file cannot be read or is refused.
pub fn read_file(path: &Path) -> Result<Vec<u8>> {
    read_head(path, u64::MAX)
}

/// Reads at most `max_bytes` bytes from the beginning of a file.
///
/// # Errors
///
/// The errors of [`read_file`].
pub fn read_head(path: &Path, max_bytes: u64) -> Result<Vec<u8>> {
    read_open(&open(path)?, max_bytes)
}

/// Opens a regular file for reading. Opening and reading it never wait for another process.
///
/// # Errors
///
/// If the file cannot be opened, or is not a regular file of a drive.
pub fn open(path: &Path) -> Result<File> {
    // Check the kind first: opening a device may have side effects.
    check_kind(&std::fs::metadata(path)?)?;
    let mut options = OpenOptions::new();
    let file = unwaiting(options.read(true)).open(path)?;
    // Check again: the path may name another file by now.
    check_kind(&file.metadata()?)?;
    check_drive(&file)?;
    Ok(file)
}

/// Reads at most `max_bytes` bytes of a file from [`open`], up to the length that the file has at the call.
///
/// # Errors
///
/// If the system cannot read the file, or the file is larger than the available memory.
pub fn read_open(file: &File, max_bytes: u64) -> Result<Vec<u8>> {
    let length = file.metadata()?.len().min(max_bytes);
    if length > LARGE
        && let Some(available) = memory::available().filter(|&available| length > available)
    {
        let (length, available) = (memory::shown(length), memory::shown(available));
        let what = format!("it has {length}, but {available} of memory are available");
        return Err(Error::new(ErrorKind::OutOfMemory, what));
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length as usize)?;
    file.take(length).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Returns the text of a regular file.
///
/// # Errors
///
/// The errors of [`read_file`], and an error if the file is not UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read_file(path)?).map_err(|_| Error::new(ErrorKind::InvalidData, "it is no UTF-8 text"))
}

/// Adds flags by which opening a pipe does not wait for its other end.
fn unwaiting(options: &mut OpenOptions) -> &mut OpenOptions {
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;

        use rustix::fs::OFlags;
        options.custom_flags((OFlags::NONBLOCK | OFlags::NOCTTY).bits() as i32);
    }
    options
}

/// Refuses folders, pipes and devices.
fn check_kind(about: &Metadata) -> Result<()> {
    if about.is_file() { Ok(()) } else { Err(Error::new(ErrorKind::InvalidInput, "it is not a file")) }
}

/// Magic numbers of file systems whose files the kernel generates on reading [statfs(2), linux/magic.h]. Some of these
/// files count as regular files and wait for events: /proc/kmsg, /sys/kernel/tracing/trace_pipe.
#[cfg(target_os = "linux")]
const MADE_UP: [u32; 22] = [
    0x0000_9fa0, // proc
    0x6265_6572, // sysfs
    0x6462_6720, // debugfs
    0x7472_6163, // tracefs
    0x7363_6673, // securityfs
    0x0027_e0eb, // cgroup
    0x6367_7270, // cgroup2
    0x6265_6570, // configfs
    0xcafe_4a11, // bpf
    0x6165_676c, // pstore
    0xf97c_ff8c, // selinux
    0x4341_5d53, // smack
    0x5a3c_69f0, // apparmor
    0xde5e_81e4, // efivarfs
    0x4249_4e4d, // binfmt_misc
    0x1980_0202, // mqueue
    0x6573_5543, // fusectl
    0x0765_5821, // resctrl
    0x6e66_7364, // nfsd
    0x6759_6969, // rpc_pipefs
    0xabba_1974, // xenfs
    0x6e73_6673, // namespaces
];

/// Refuses files that the system generates on reading.
#[cfg(target_os = "linux")]
fn check_drive(file: &File) -> Result<()> {
    // Sign and width of the number differ between platforms.
    let kind = rustix::fs::fstatfs(file)?.f_type as u32;
    if MADE_UP.contains(&kind) {
        let what = "it is not a file of a drive: the system makes it up as it is read";
        return Err(Error::new(ErrorKind::InvalidInput, what));
    }
    Ok(())
}

/// Accepts every drive: other systems do not present devices as regular files.
#[cfg(not(target_os = "linux"))]
fn check_drive(_: &File) -> Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regular_files_are_read_and_all_other_kinds_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, "abc").unwrap();
        assert_eq!(read_file(&path).unwrap(), b"abc");
        assert_eq!(read_text(&path).unwrap(), "abc");
        assert_eq!(read_head(&path, 2).unwrap(), b"ab");
        std::fs::write(&path, b"\xFF").unwrap();
        assert_eq!(read_text(&path).unwrap_err().kind(), ErrorKind::InvalidData);
        assert!(read_file(folder.path()).is_err());
        assert_eq!(read_file(&folder.path().join("b")).unwrap_err().kind(), ErrorKind::NotFound);
        #[cfg(unix)]
        for device in ["/dev/zero", "/dev/tty", "/dev/random"].map(Path::new) {
            assert!(!device.exists() || read_file(device).is_err(), "{}", device.display());
        }
    }

    /// The system reports some of these files as regular files.
    #[cfg(target_os = "linux")]
    #[test]
    fn files_that_the_system_generates_are_refused_at_once() {
        let all = [
            "/proc/kmsg",
            "/proc/self/status",
            "/proc/self/mem",
            "/proc/self/pagemap",
            "/proc/mounts",
            "/sys/kernel/uevent_seqnum",
            "/sys/fs/cgroup/cgroup.procs",
            "/sys/kernel/tracing/trace_pipe",
            "/sys/kernel/debug/tracing/trace_pipe",
        ];
        for path in all.map(Path::new).into_iter().filter(|path| path.exists()) {
            assert!(read_file(path).is_err(), "{}", path.display());
        }
        let error = read_file(Path::new("/proc/self/status")).unwrap_err().to_string();
        assert!(error.contains("the system makes it up"), "{error}");
        // A link to a generated file is refused. A link of /proc to a file of a drive is read as that file.
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("status");
        std::os::unix::fs::symlink("/proc/self/status", &link).unwrap();
        assert!(read_file(&link).is_err());
        let file = folder.path().join("a");
        std::fs::write(&file, "abc").unwrap();
        let open = File::open(&file).unwrap();
        let number = std::os::fd::AsRawFd::as_raw_fd(&open);
        assert_eq!(read_file(Path::new(&format!("/proc/self/fd/{number}"))).unwrap(), b"abc");
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_without_a_writer_is_refused_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        assert_eq!(open(&pipe).unwrap_err().kind(), ErrorKind::InvalidInput);
        // Opening does not wait either where a pipe replaces the file between two checks.
        assert!(unwaiting(OpenOptions::new().read(true)).open(&pipe).is_ok());
        assert!(unwaiting(OpenOptions::new().write(true)).open(folder.path().join("pipe")).is_err());
    }

    #[test]
    fn a_file_beyond_memory_is_refused_before_it_is_read() {
        // A sparse file has a length and takes no room.
        let file = tempfile::NamedTempFile::new().unwrap();
        if file.as_file().set_len(1 << 50).is_err() || memory::available().is_none() {
            return; // The file system has a lower limit, or the system does not report its memory.
        }
        let error = read_file(file.path()).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::OutOfMemory);
        assert!(error.to_string().contains("are available"), "{error}");
    }
}
