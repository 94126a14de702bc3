//! How a call ends.

/// Why a call has failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Failure {
    /// An argument is wrong: which one, where, and what to do.
    Invalid(String),
    /// The call comes too early or too late.
    Order(String),
    /// The caller has stopped it.
    Cancelled,
    /// Another call goes on.
    Busy(String),
    /// Bytes are not what they should be, or of something else.
    Data(String),
    /// There is not enough memory.
    Memory(String),
    /// A defect of this library.
    Panicked(String),
}

/// What a call returns.
pub type Result<T> = std::result::Result<T, Failure>;

impl Failure {
    /// The same of a part: its name goes before the field's.
    pub fn of(self, part: &str) -> Self {
        match self {
            Self::Invalid(message) => Self::Invalid(format!("{part}.{message}")),
            other => other,
        }
    }

    /// What a panic said.
    pub fn from_panic(payload: &(dyn std::any::Any + Send)) -> Self {
        let text = payload.downcast_ref::<&str>().copied();
        let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
        Self::Panicked(format!("a defect of covbeam: {}", text.unwrap_or("a panic")))
    }
}

impl std::error::Error for Failure {}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Invalid(message)
            | Self::Order(message)
            | Self::Busy(message)
            | Self::Data(message)
            | Self::Memory(message)
            | Self::Panicked(message) => f.write_str(message),
            Self::Cancelled => f.write_str("stopped by the caller"),
        }
    }
}

/// A [`Failure::Invalid`] with a formatted message.
macro_rules! invalid {
    ($($message:tt)*) => { $crate::work::failure::Failure::Invalid(format!($($message)*)) };
}
pub(crate) use invalid;
