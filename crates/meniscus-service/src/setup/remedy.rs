//! Remedies of missed checks, in words for the person in front of the glass.

pub(super) const NOTHING: &str = "no body of liquid stands out from its background in the middle third of the \
    image: put the glass before the middle of the camera, 30 to 60 cm away, with an even wall or card 20 cm or more \
    behind it; if it stands there, the liquid is clear in the near infrared: make it opaque (a spoon of milk or ink in a \
    litre), and light the wall behind it, not the glass; clear water can be seen with --outline clear, a white card behind \
    it and a lamp of 850 nm";
pub(super) const TRANSPARENT: &str = "the depth image looks through the liquid to the wall behind it: the liquid is \
    transparent in the near infrared and its surface cannot be measured; make it opaque with a spoon of milk or \
    titanium white (bright), or of ink that contains carbon (dark), and look again; or leave it clear, put a white card behind it and a lamp of \
    850 nm on the card, and give --outline clear";
pub(super) const CLEAR_CARD: &str = "what is behind the glass is too dark to show a clear liquid before it: put a white \
    card 20 to 30 cm behind the glass, wider than the glass on both sides, with a lamp of 850 nm on it";
pub(super) const CLEAR_LAMP: &str = "the card behind the glass is bright and the liquid takes too little of its light: \
    water absorbs at 850 nm and not in visible light. Put an infrared lamp of 850 nm (as security cameras have) on the \
    card and darken the room; lamps of white LEDs have none of it. If that does not do, make the liquid opaque";
pub(super) const CLEAR_BRIGHT: &str = "the card behind the glass is whiter than white: take light from it, or the step to \
    the liquid is cut off";
pub(super) const CLEAR_PLACE: &str = "the depth image shows the wall behind the glass or nothing, so that the glass's \
    distance is not known: measure it and give --distance-mm (from the lens to the wall of the glass) and \
    --camera-height-mm (of the lens above the inner bottom)";
pub(super) const CLEAR_RADIUS: &str = "the silhouette of the glass does not fit to its distance and radius: the radius seen \
    is that of the outer wall and grows with the distance; measure the distance from the lens to the wall and give it with \
    --distance-mm and --camera-height-mm";
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
    say: measure the inner diameter at the height of the liquid and halve it; a thick wall is seen up to its outer radius: \
    measure its thickness and give it with --wall-mm, or as wall in the wizard";
pub(super) const FILL: &str = "the liquid stands higher or lower above its foot than you say: measure from the inner \
    bottom to the surface; if the foot is hidden, uncover it; a thick base may show the colour of the liquid: measure its \
    thickness and give it with --base-mm, or as base in the wizard";
pub(super) const RADIUS_STATED: &str = "the sides of the liquid do not fit to the stated lens, distance and radius: the radius \
    seen grows with the stated distance and falls with the focal length; measure all three again, the distance from the \
    lens to the wall of the glass, and the focal length in px of this image size";
pub(super) const FILL_STATED: &str = "the height of the liquid in the image does not fit to the stated lens, distance and \
    fill: measure them again, the fill from the inner bottom to the surface; if the foot is hidden, uncover it";
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
