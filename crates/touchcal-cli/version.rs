//! The version that build scripts give to the command line and the Python package.

use std::path::Path;
use std::process::Command;

/// Sets `TOUCHCAL_VERSION` to the version, with the git revision where the sources, whose folder is
/// `root`, are a checkout.
pub fn set(root: &Path) {
    let git = |args: &[&str]| {
        let output = Command::new("git").arg("-C").arg(root).args(args).output().ok().filter(|o| o.status.success())?;
        String::from_utf8(output.stdout).ok().map(|text| text.trim().to_owned())
    };
    let mut version = env!("CARGO_PKG_VERSION").to_owned();
    // A folder above that is another project's checkout has nothing to do with this revision.
    if root.join(".git").exists() {
        // Both change with the revision: the log of HEAD with each commit and checkout.
        for name in ["HEAD", "logs/HEAD"] {
            let path = git(&["rev-parse", "--git-path", name]).map(|path| root.join(path));
            if let Some(path) = path.filter(|path| path.exists()) {
                println!("cargo:rerun-if-changed={}", path.display());
            }
        }
        if let Some(revision) = git(&["rev-parse", "--short=12", "HEAD"]) {
            version += &format!(" ({revision})");
        }
    }
    println!("cargo:rustc-env=TOUCHCAL_VERSION={version}");
}
