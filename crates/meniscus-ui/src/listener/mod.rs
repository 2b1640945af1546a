//! Front of every server here: heads read within limits, senders checked, places shared out among addresses.
//!
//! The live page and the Foxglove server both stand behind it, so that neither can forget a check.

mod connection;
mod head;
mod places;
mod sender;
mod timed_stream;

pub(crate) use head::{HEAD_WITHIN, HeadFault, read};
pub(crate) use places::{Limits, Place, Places};
pub(crate) use sender::{Hosts, SenderFault, Senders, check_sender};
pub(crate) use timed_stream::TimedStream;
