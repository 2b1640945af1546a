//! What a person sees: the dashboard while it runs, the picture at the end.
