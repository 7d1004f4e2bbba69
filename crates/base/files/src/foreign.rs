//! What all readers say of files that they cannot read: pointers of Git LFS, compressed recordings.

/// What a pointer is called, and what to do about it.
pub const GIT_LFS_POINTER: [&str; 2] =
    ["a Git LFS pointer, not the file itself", "fetch it with `git lfs pull`"];

/// Whether a file that begins so is a pointer of Git LFS ([`GIT_LFS_POINTER`]).
pub fn is_git_lfs_pointer(head: &[u8]) -> bool {
    head.starts_with(b"version https://git-lfs")
}

/// What was expected instead of chunks of an MCAP file that are compressed so, what was found, and what to do.
pub fn compressed_chunks(compression: &str) -> [String; 2] {
    [
        "chunks without compression".to_owned(),
        format!(
            "chunks compressed with {compression}; `mcap decompress IN.mcap -o OUT.mcap` writes a copy without \
             (https://mcap.dev/guides/cli)"
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pointer_is_recognized_by_its_first_line() {
        assert!(is_git_lfs_pointer(
            b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n"
        ));
        assert!(!is_git_lfs_pointer(b"version 1") && !is_git_lfs_pointer(b""));
    }
}
