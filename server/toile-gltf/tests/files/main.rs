//! Reading and writing files, hostile ones among them.

#![allow(missing_docs)]

mod hostile;
mod limits;
mod obj;
mod reading;
mod support;
mod units;
mod writing;
