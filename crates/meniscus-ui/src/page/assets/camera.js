// The camera's image with the traced and the estimated surface on it.

import { colours } from './colours.js';

/** Grey below which a pixel has no depth: the JPEG moves it by a few. */
const NO_DEPTH = 12;

/** The depth image in colours: near is the upper end of the scale. */
function coloured(bitmap, width, height) {
  const sheet = new OffscreenCanvas(width, height);
  const pen = sheet.getContext('2d');
  pen.drawImage(bitmap, 0, 0);
  const picture = pen.getImageData(0, 0, width, height);
  const [pixels, map] = [picture.data, colours()];
  for (let k = 0; k < pixels.length; k += 4) {
    const grey = pixels[k];
    for (let c = 0; c < 3; c++) pixels[k + c] = grey < NO_DEPTH ? 0 : map[4 * grey + c];
  }
  pen.putImageData(picture, 0, 0);
  return sheet;
}

export class Camera {
  constructor(canvas) {
    this.canvas = canvas;
    this.time = NaN;
    this.drawn = 0;
    this.busy = false;
    this.next = null;
  }

  /** When an image was taken, s of the camera's time, from its bytes. */
  static timeOf(buffer) { return new DataView(buffer).getFloat64(8, true); }

  /** Takes the bytes of an image that may be older than the one that stands there. */
  again(buffer) {
    this.drawn = -1;
    return this.take(buffer);
  }

  /** Takes an image's bytes. Decoding takes a moment; of those that come meanwhile only the newest is kept. */
  async take(buffer) {
    this.next = buffer;
    if (this.busy) return;
    this.busy = true;
    try {
      while (this.next) {
        const newest = this.next;
        this.next = null;
        await this.decode(newest);
      }
    } finally {
      this.busy = false;
    }
  }

  async decode(buffer) {
    const view = new DataView(buffer);
    const number = view.getUint32(4, true);
    const [width, height, traced, estimated] = [16, 18, 20, 22].map((at) => view.getUint16(at, true));
    const isDepth = view.getUint8(1) === 1;
    const points = new Float32Array(buffer, 32, 2 * (traced + estimated));
    const jpeg = new Blob([new Uint8Array(buffer, 32 + points.byteLength)], { type: 'image/jpeg' });
    const bitmap = await createImageBitmap(jpeg);
    if (number > this.drawn) {
      this.drawn = number;
      this.time = Camera.timeOf(buffer);
      /** Ends of the depth scale, m; null for the image of the outline. */
      this.range = isDepth ? [view.getFloat32(24, true), view.getFloat32(28, true)] : null;
      this.draw(isDepth ? coloured(bitmap, width, height) : bitmap, width, height, points.subarray(0, 2 * traced), points.subarray(2 * traced));
    }
    bitmap.close();
  }

  draw(bitmap, width, height, traced, estimated) {
    const { canvas } = this;
    const zoom = Math.max(1, Math.round(canvas.clientWidth * devicePixelRatio / width * 4) / 4);
    if (canvas.width !== Math.round(width * zoom) || canvas.height !== Math.round(height * zoom)) {
      canvas.width = Math.round(width * zoom);
      canvas.height = Math.round(height * zoom);
      canvas.style.aspectRatio = `${width} / ${height}`;
    }
    const ink = getComputedStyle(canvas);
    const pen = canvas.getContext('2d');
    pen.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
    const each = (points, act) => {
      for (let k = 0; k < points.length; k += 2) act((points[k] + 0.5) * zoom, (points[k + 1] + 0.5) * zoom, k);
    };
    pen.lineWidth = 2 * devicePixelRatio;
    pen.strokeStyle = ink.getPropertyValue('--estimated');
    pen.beginPath();
    each(estimated, (x, y, k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
    pen.stroke();
    pen.fillStyle = ink.getPropertyValue('--measured');
    each(traced, (x, y) => {
      pen.beginPath();
      pen.arc(x, y, 2.2 * devicePixelRatio, 0, 7);
      pen.fill();
    });
  }

  /** Nothing of it is true any more: another run. */
  forget() {
    this.time = NaN;
    this.drawn = 0;
    this.canvas.getContext('2d').clearRect(0, 0, this.canvas.width, this.canvas.height);
  }
}
