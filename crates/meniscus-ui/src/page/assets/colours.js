// Viridis (van der Walt and Smith, 2015): even in lightness, and distinguishable by the colour-blind.

const STOPS = [0x440154, 0x482878, 0x3e4989, 0x31688e, 0x26828e, 0x1f9e89, 0x35b779, 0x6ece58, 0xb5de2b, 0xfde725];

/** 256 colours as RGBA bytes. */
export function colours() {
  const bytes = new Uint8Array(4 * 256);
  for (let k = 0; k < 256; k++) {
    const at = k / 255 * (STOPS.length - 1);
    const low = Math.min(Math.floor(at), STOPS.length - 2);
    for (let shift = 16, c = 0; c < 3; shift -= 8, c++) {
      const [a, b] = [STOPS[low], STOPS[low + 1]].map((stop) => stop >> shift & 255);
      bytes[4 * k + c] = Math.round(a + (b - a) * (at - low));
    }
    bytes[4 * k + 3] = 255;
  }
  return bytes;
}

/** Draws the colours from left to right. */
export function drawBar(canvas) {
  const pixels = new ImageData(new Uint8ClampedArray(colours()), 256, 1);
  canvas.getContext('2d').putImageData(pixels, 0, 0);
}

/** A limit of an axis or a legend that does not flicker: 1, 1.5, 2, 3, 5 or 7 times a power of ten. */
export function niceAbove(value) {
  if (!(value > 0)) return 1e-6;
  const power = 10 ** Math.floor(Math.log10(value));
  return power * ([1, 1.5, 2, 3, 5, 7, 10].find((step) => step * power >= value * 0.9999) ?? 10);
}

/** A number with a few digits, for people. */
export function shortNumber(value) {
  if (!Number.isFinite(value)) return '-';
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e5)) return value.toExponential(1);
  return value.toFixed(size >= 100 || size === 0 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : 3);
}
