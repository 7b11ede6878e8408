//! Whether the memory for something large is there, asked before the work begins: what the system promises and then does not
//! have ends a process without a word.

use std::path::{Path, PathBuf};

/// Refuses what does not fit into the memory that is left, on Linux by what the system, the process's control group and its
/// limits say; elsewhere, and besides, by asking for it.
///
/// # Errors
/// One line with both numbers; `what` is its subject.
pub fn require(what: &str, bytes: u64) -> Result<(), String> {
    let gigabytes = |b: u64| format!("{:.1} GB", b as f64 / 1e9);
    if let Some(available) = available().filter(|available| bytes > *available) {
        return Err(format!("{what} needs {} of memory, {} are left", gigabytes(bytes), gigabytes(available)));
    }
    let mut memory = Vec::<u8>::new();
    let reserved = usize::try_from(bytes).ok().and_then(|n| memory.try_reserve_exact(n).ok());
    // Otherwise the compiler sees that nothing is done with it, and asks for nothing.
    std::hint::black_box(&memory);
    reserved.ok_or_else(|| format!("{what} needs {} of memory, which is not there", gigabytes(bytes)))
}

/// Bytes that the process can still get; `None` where nobody says.
fn available() -> Option<u64> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let kilobytes = |text: &str, key: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(key));
        line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok()).map(|n| n << 10)
    };
    let info = read("/proc/meminfo");
    let system =
        info.and_then(|info| Some(kilobytes(&info, "MemAvailable:")? + kilobytes(&info, "SwapFree:").unwrap_or(0)));
    // The address space: soft limit (`ulimit -v`) less what is in use.
    let limits = read("/proc/self/limits");
    let limit = limits.and_then(|text| {
        let line = text.lines().find_map(|line| line.strip_prefix("Max address space"))?;
        line.split_whitespace().next()?.parse::<u64>().ok()
    });
    let used = read("/proc/self/status").and_then(|status| kilobytes(&status, "VmSize:")).unwrap_or(0);
    let space = limit.map(|limit| limit.saturating_sub(used));
    let groups = read("/proc/self/cgroup").unwrap_or_default();
    [system, space, control_groups(&groups, Path::new("/sys/fs/cgroup"))].into_iter().flatten().min()
}

/// What the control groups of a process leave, by the lines of `/proc/self/cgroup`: the least along each path.
fn control_groups(lines: &str, root: &Path) -> Option<u64> {
    let left = lines.lines().flat_map(|line| {
        let mut parts = line.splitn(3, ':').skip(1);
        let (controllers, path) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
        let version_2 = controllers.is_empty();
        let mounted = match version_2 {
            true => root.to_path_buf(),
            false => root.join("memory"),
        };
        let concerns = version_2 || controllers.split(',').any(|c| c == "memory");
        let inside: Vec<PathBuf> = Path::new(path.trim_start_matches('/'))
            .ancestors()
            .filter(|_| concerns)
            .map(|group| mounted.join(group))
            .collect();
        inside.into_iter().filter_map(move |group| left_in(&group, version_2))
    });
    left.min()
}

/// What one control group leaves: its limit less what is in use and cannot be dropped.
fn left_in(group: &Path, version_2: bool) -> Option<u64> {
    let (limit, usage, cache) = match version_2 {
        true => ("memory.max", "memory.current", "inactive_file"),
        false => ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"),
    };
    let number = |name: &str| std::fs::read_to_string(group.join(name)).ok()?.trim().parse::<u64>().ok();
    let (limit, usage) = (number(limit)?, number(usage)?);
    let stat = std::fs::read_to_string(group.join("memory.stat")).unwrap_or_default();
    let dropped = stat.lines().find_map(|line| line.strip_prefix(cache)?.trim().parse::<u64>().ok()).unwrap_or(0);
    Some(limit.saturating_sub(usage.saturating_sub(dropped)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_machine_has_is_refused() {
        assert_eq!(require("a film", 1 << 20), Ok(()));
        let message = require("a film", 1 << 60).unwrap_err();
        assert!(message.starts_with("a film needs 1152921504.6 GB of memory, "), "{message}");
        assert!(require("a film", u64::MAX).is_err());
    }

    #[test]
    fn the_tightest_control_group_counts() {
        let folder = tempfile::tempdir().unwrap();
        let group = |name: &str, files: &[(&str, &str)]| {
            std::fs::create_dir_all(folder.path().join(name)).unwrap();
            for (file, text) in files {
                std::fs::write(folder.path().join(name).join(file), text).unwrap();
            }
        };
        group("a/b", &[("memory.max", "max\n"), ("memory.current", "5\n")]);
        let stat = "anon 1\ninactive_file 100\n";
        group("a", &[("memory.max", "1000\n"), ("memory.current", "300\n"), ("memory.stat", stat)]);
        group("memory/c", &[("memory.limit_in_bytes", "700\n"), ("memory.usage_in_bytes", "600\n")]);
        let left = |lines| control_groups(lines, folder.path());
        assert_eq!(left("0::/a/b\n"), Some(800));
        assert_eq!(left("9:cpu,memory:/c\n0::/a/b\n"), Some(100));
        assert_eq!((left("3:cpu:/c\n"), left("")), (None, None));
    }
}
