//! The walk over a configuration descriptor: descriptors by bLength, interfaces with what belongs to them.
//!
//! The same walk reads the class-specific `extra` bytes that an operating system keeps an interface.
//! A length that is impossible ends the walk with its place; nothing behind it is guessed at.
//!
//! Source: USB 3.2, section 9.6; USB Video Class 1.5, section 3.

/// Types of descriptors.
const INTERFACE: u8 = 0x04;
const ENDPOINT: u8 = 0x05;
const ASSOCIATION: u8 = 0x0b;
const CLASS_INTERFACE: u8 = 0x24;

/// Fault in a row of descriptors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DescriptorError {
    /// bLength is below 2, so the walk would never move on.
    Length {
        /// Offset of the descriptor.
        at: usize,
        /// Its bLength.
        length: usize,
    },
    /// bLength reaches beyond the end.
    BeyondEnd {
        /// Offset of the descriptor.
        at: usize,
        /// Its bLength.
        length: usize,
        /// Bytes that are left.
        left: usize,
    },
}

impl core::fmt::Display for DescriptorError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Length { at, length } => {
                write!(f, "the descriptor at byte {at} says that it is {length} long")
            }
            Self::BeyondEnd { at, length, left } => {
                write!(f, "the descriptor at byte {at} says that it is {length} long, {left} bytes are left")
            }
        }
    }
}

impl core::error::Error for DescriptorError {}

/// One descriptor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Descriptor<'a> {
    /// bDescriptorType.
    pub kind: u8,
    /// All of it, bLength first, at least two bytes.
    pub bytes: &'a [u8],
}

impl<'a> Descriptor<'a> {
    /// The byte at `at`.
    #[must_use]
    pub fn byte(&self, at: usize) -> Option<u8> {
        self.bytes.get(at).copied()
    }

    /// bDescriptorSubtype of a class-specific interface descriptor.
    #[must_use]
    pub fn class_subtype(&self) -> Option<u8> {
        self.byte(2).filter(|_| self.kind == CLASS_INTERFACE)
    }
}

/// The walk.
///
/// ```
/// use meniscus::usb::uvc::descriptor::{DescriptorError, Descriptors};
///
/// // One of two bytes, then one that claims to be nine long.
/// let mut walk = Descriptors::new(&[2, 0x0b, 9, 4]);
/// assert_eq!(walk.next().map(|d| d.map(|d| d.kind)), Some(Ok(0x0b)));
/// assert_eq!(walk.next(), Some(Err(DescriptorError::BeyondEnd { at: 2, length: 9, left: 2 })));
/// assert_eq!(walk.next(), None);
/// ```
#[derive(Clone, Debug)]
pub struct Descriptors<'a> {
    rest: &'a [u8],
    at: usize,
}

impl<'a> Descriptors<'a> {
    /// A walk over `bytes`.
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes, at: 0 }
    }
}

impl<'a> Iterator for Descriptors<'a> {
    type Item = Result<Descriptor<'a>, DescriptorError>;

    fn next(&mut self) -> Option<Self::Item> {
        let (rest, at) = (core::mem::take(&mut self.rest), self.at);
        let length = usize::from(*rest.first()?);
        if length < 2 {
            return Some(Err(DescriptorError::Length { at, length }));
        }
        let Some((bytes, behind)) = rest.split_at_checked(length) else {
            return Some(Err(DescriptorError::BeyondEnd { at, length, left: rest.len() }));
        };
        self.rest = behind;
        self.at = self.at.saturating_add(length);
        Some(Ok(Descriptor { kind: bytes.get(1).copied().unwrap_or(0), bytes }))
    }
}

/// Checks that the walk reaches the end.
///
/// ```
/// use meniscus::usb::uvc::descriptor::{DescriptorError, check};
///
/// assert_eq!(check(&[3, 4, 0, 2, 5]), Ok(()));
/// assert_eq!(check(&[3, 4, 0, 0]), Err(DescriptorError::Length { at: 3, length: 0 }));
/// ```
///
/// # Errors
/// [`DescriptorError`] of the first descriptor that cannot be one.
pub fn check(configuration: &[u8]) -> Result<(), DescriptorError> {
    Descriptors::new(configuration).try_for_each(|descriptor| descriptor.map(drop))
}

/// An interface in one alternate setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interface<'a> {
    /// bInterfaceNumber.
    pub number: u8,
    /// bAlternateSetting.
    pub alternate: u8,
    /// bInterfaceClass and bInterfaceSubClass.
    pub class: (u8, u8),
    /// Descriptors that belong to it: class-specific ones and endpoints.
    pub extra: &'a [u8],
}

/// Class and subclass of a video control interface.
pub const VIDEO_CONTROL: (u8, u8) = (0x0e, 1);
/// Class and subclass of a video streaming interface.
pub const VIDEO_STREAMING: (u8, u8) = (0x0e, 2);

/// An endpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Endpoint {
    /// bEndpointAddress; bit 7 is set for IN.
    pub address: u8,
    /// Transfer type: 0 control, 1 isochronous, 2 bulk, 3 interrupt.
    pub kind: u8,
    /// wMaxPacketSize.
    pub packet: u16,
}

impl<'a> Interface<'a> {
    /// The class-specific descriptors with their subtypes.
    pub fn class_specific(&self) -> impl Iterator<Item = (u8, Descriptor<'a>)> + Clone + use<'a> {
        Descriptors::new(self.extra).map_while(Result::ok).filter_map(|d| Some((d.class_subtype()?, d)))
    }

    /// Its endpoints.
    pub fn endpoints(&self) -> impl Iterator<Item = Endpoint> + use<'a> {
        Descriptors::new(self.extra).map_while(Result::ok).filter(|d| d.kind == ENDPOINT).filter_map(|d| {
            let packet = super::bytes::u16_at(d.bytes, 4)?;
            Some(Endpoint { address: d.byte(2)?, kind: d.byte(3)? & 0b11, packet })
        })
    }

    /// The first IN endpoint of a transfer type.
    #[must_use]
    pub fn input(&self, kind: u8) -> Option<Endpoint> {
        self.endpoints().find(|endpoint| endpoint.kind == kind && endpoint.address & 0x80 != 0)
    }
}

/// The interfaces of a configuration, in its order; the walk ends where the bytes are no descriptors,
/// which [`check`] tells.
///
/// ```
/// use meniscus::usb::uvc::descriptor::{VIDEO_CONTROL, interfaces};
///
/// const CONFIGURATION: [u8; 25] = [
///     9, 2, 25, 0, 1, 1, 0, 0xc0, 55, // configuration
///     9, 4, 0, 0, 1, 0x0e, 1, 0, 0, // interface 0: video control
///     7, 5, 0x87, 3, 64, 0, 6, // its interrupt endpoint, IN
/// ];
/// let control = interfaces(&CONFIGURATION).find(|interface| interface.class == VIDEO_CONTROL);
/// let interrupt = control.and_then(|interface| interface.input(3));
/// assert_eq!(interrupt.map(|endpoint| (endpoint.address, endpoint.packet)), Some((0x87, 64)));
/// ```
pub fn interfaces(configuration: &[u8]) -> impl Iterator<Item = Interface<'_>> {
    let mut rest = configuration;
    core::iter::from_fn(move || {
        loop {
            let descriptor = Descriptors::new(rest).next()?.ok()?;
            rest = rest.get(descriptor.bytes.len()..)?;
            if descriptor.kind == INTERFACE {
                let class = (descriptor.byte(5)?, descriptor.byte(6)?);
                let (number, alternate) = (descriptor.byte(2)?, descriptor.byte(3)?);
                return Some(Interface { number, alternate, class, extra: own(rest) });
            }
        }
    })
}

/// The part of `rest` that ends before the next interface or interface association.
fn own(rest: &[u8]) -> &[u8] {
    let belongs = |d: &Descriptor<'_>| d.kind != INTERFACE && d.kind != ASSOCIATION;
    let descriptors = Descriptors::new(rest).map_while(Result::ok).take_while(belongs);
    let length = descriptors.fold(0_usize, |sum, descriptor| sum.saturating_add(descriptor.bytes.len()));
    rest.get(..length).unwrap_or(&[])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A configuration header, a control interface with an interrupt endpoint, an association, a
    /// streaming interface with a bulk endpoint and its SuperSpeed companion.
    const CONFIGURATION: [u8; 57] = [
        9, 2, 57, 0, 2, 1, 0, 0xc0, 55, // configuration
        9, 4, 0, 0, 1, 0x0e, 1, 0, 0, // interface 0
        7, 5, 0x87, 3, 64, 0, 6, // interrupt IN
        8, 0x0b, 3, 2, 0x0e, 3, 0, 0, // association
        9, 4, 1, 0, 1, 0x0e, 2, 0, 0, // interface 1
        2, 0x24, // a class-specific descriptor without a subtype
        7, 5, 0x82, 2, 0, 4, 0, // bulk IN, 1024
        6, 0x30, 15, 0, 0, 0, // companion, burst 15
    ];

    #[test]
    fn endpoints_belong_to_their_interface() {
        assert_eq!(check(&CONFIGURATION), Ok(()));
        let mut all = interfaces(&CONFIGURATION);
        let control = all.next().expect("interface 0");
        assert_eq!((control.number, control.class, control.extra.len()), (0, VIDEO_CONTROL, 7));
        assert_eq!(control.input(3).map(|e| e.address), Some(0x87));
        let streaming = all.next().expect("interface 1");
        assert_eq!(streaming.class, VIDEO_STREAMING);
        assert_eq!(streaming.input(2), Some(Endpoint { address: 0x82, kind: 2, packet: 1024 }));
        assert_eq!(streaming.class_specific().count(), 0);
        assert!(all.next().is_none());
    }

    #[test]
    fn an_impossible_length_is_refused_with_its_place() {
        let mut bytes = CONFIGURATION;
        bytes[18] = 0;
        assert_eq!(check(&bytes), Err(DescriptorError::Length { at: 18, length: 0 }));
        assert_eq!(interfaces(&bytes).count(), 1, "what stands before it is read");
        let cut = &CONFIGURATION[..50];
        assert_eq!(check(cut), Err(DescriptorError::BeyondEnd { at: 44, length: 7, left: 6 }));
    }
}
