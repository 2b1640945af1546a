//! Laws that no library holds, hidden in liquids of another solver: how well a drawn law finds them.
//!
//! | file | purpose |
//! |---|---|
//! | `solver` | modes of a glass by a fourth-order Runge-Kutta integration, which shares no code with the reduced model |
//! | `laws` | the hidden laws |
//! | `trials` | recordings of that solver as the workflow gets them, the trials and what is found in each |
//! | `checks` | tally of the trials |

pub mod checks;
pub mod laws;
pub mod solver;
pub mod trials;
