//! A campaign with volunteers: its protocol, the check of its design, the plan of each person, and the session.

pub mod design;
