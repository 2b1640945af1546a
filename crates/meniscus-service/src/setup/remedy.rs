//! Remedies of missed checks, in words for the person in front of the glass.

pub(super) const NOTHING: &str = "no body of liquid stands out from its background in the middle third of the \
    image: put the glass before the middle of the camera, 30 to 60 cm away, with an even wall or card 20 cm or more \
    behind it; if it stands there, the liquid is clear in the near infrared: make it opaque (a spoon of milk or ink in a \
    litre), and light the wall behind it, not the glass";
pub(super) const TRANSPARENT: &str = "the depth image looks through the liquid to the wall behind it: the liquid is \
    transparent in the near infrared and its surface cannot be measured; make it opaque with a spoon of milk or \
    titanium white (bright), or of ink that contains carbon (dark), and look again";
pub(super) const NO_DEPTH: &str = "most of the glass has no depth: take away lamps that mirror in it, turn the projector \
    on, put tape or a paper strip with print on the side of the glass that is not looked at, and keep 30 cm away";
pub(super) const CONTRAST: &str = "liquid and background are too alike for the camera: another card behind the glass, \
    bright behind a dark liquid and dark behind a bright one";
pub(super) const OFFSET: &str = "shift camera or glass until the glass stands before the middle of the image";
pub(super) const DISTANCE: &str = "put the camera 250 to 700 mm from the glass; nearer it has no depth, farther a pixel \
    is more than 2 mm";
pub(super) const HEIGHT: &str = "the camera must stand below the liquid's surface and above the foot of the glass, or it \
    looks at the surface from above: lower it, or raise the glass";
pub(super) const PITCH: &str = "the camera looks too steeply: level it to within 15 degrees";
pub(super) const RADIUS: &str = "the sides of the liquid and their depth belong to a glass of another radius than you \
    say: measure the inner diameter at the height of the liquid and halve it; a thick wall magnifies, then say what the \
    camera sees";
pub(super) const FILL: &str = "the liquid stands higher or lower above its foot than you say: measure from the inner \
    bottom to the surface; if the foot is hidden, uncover it";
pub(super) const SEEN: &str =
    "hold everything still and keep hands out of the picture; see what the reader says";
pub(super) const POINTS: &str =
    "part of the liquid's edge is hidden: foam, a highlight on the glass or something before it";
pub(super) const LEVEL: &str = "the surface moves: wait until it is still and look again";
pub(super) const SLOPE: &str = "the surface at rest is not level in the image: turn the camera about its own axis until \
    it is (1 degree is 1.2 mm over a glass of 70 mm), or level the table";
pub(super) const NOISE: &str =
    "the liquid is not still yet, or the camera shakes: wait, and fix the camera to the table";
pub(super) const BEND: &str = "the edge of the liquid is not straight: drops or a film above it, foam, or liquid that is \
    still moving";
