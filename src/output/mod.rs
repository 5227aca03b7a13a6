//! Results on disk: folders that are there in whole or not at all, and folders of records that a later run goes on
//! with.
//!
//! What a program that ends where it stands must remove is kept in [`leftovers`].

mod claim;
mod contents;
mod error;
mod folder;
pub mod leftovers;
mod order;
mod records;
mod whole;
mod worker;

pub use claim::Claim;
pub use contents::{RESULT, SCENE, described};
pub use error::{OutputError, Remedy};
pub use folder::{Finished, OutputFolder};
pub use records::{Item, Records};
pub use whole::{fill_whole, must_be_free, write_new, write_whole};
pub use worker::Claimed;
