//! Laws that no library holds, hidden in liquids of another solver: how well a drawn law finds them.
//!
//! | file | purpose |
//! |---|---|
//! | `solver` | modes of a glass by a fourth-order Runge-Kutta integration, which shares no code with the reduced model |
//! | `laws` | the hidden laws |
//! | `recordings` | recordings of that solver as the workflow gets them |
//! | `trials` | what is hidden, in which glass, with which library |
//! | `judge` | judgement by the workflow, and the law that is found beside the hidden one |
//! | `checks` | tally of the trials |

pub mod checks;
pub mod judge;
pub mod laws;
pub mod recordings;
pub mod solver;
pub mod trials;
