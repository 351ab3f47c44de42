//! `touchcal convert`.

use touchcal::io::contact_log::LogTable;
use touchcal::io::urdf::{self, Ends};
use touchcal::robot::builtin;

use crate::args::ConvertArgs;
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::progress::Spinner;

/// Reads a log, writes it in another format, prints its size and columns.
pub fn run(args: &ConvertArgs) -> Result<Outcome, Failure> {
    super::prepare_outputs([args.out.clone()], [args.log.as_path(), args.urdf.as_path()])?;
    let name = args.urdf.to_str().filter(|name| builtin::ALL.iter().any(|(known, _)| known == name));
    let ends = Ends { base: None, tip: args.tip.as_deref() };
    let arm = match name {
        Some(name) => urdf::read_builtin(name, ends)?,
        None => urdf::read_file(&args.urdf, ends)?,
    };
    let spinner = Spinner::new("Reading");
    spinner.run();
    let table = LogTable::read_file(&args.log, &arm.robot, &args.options())?;
    drop(spinner);
    output::notes(table.notes());
    crate::progress::defer_interrupts();
    table.write_file(&args.out)?;
    let (rows, columns) = (table.rows().len(), table.columns().join(", "));
    output::print(&format!("{}: {rows} rows of {columns}\n", args.out.display()))?;
    Ok(Outcome::Done)
}
