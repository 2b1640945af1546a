// The last seconds, to be looked at again while the page is paused.

/** Frames and images are kept for so long. A frame has some kilobytes, an image some tens. */
const KEPT_S = 20;

/** A camera's clock that goes back by more began anew. A late frame comes behind the turns that were made without it. */
export const CLOCK_ANEW_S = 1;

export class Past {
  constructor() { this.forget(); }

  /** Another run, or a camera whose clock began anew: the times before it cannot be compared. */
  forget() {
    this.frames = [];
    this.images = [];
  }

  frame(frame) {
    if (frame.time < this.frames.at(-1)?.time - CLOCK_ANEW_S) this.forget();
    this.frames.push(frame);
    while (frame.time - this.frames[0].time > KEPT_S) this.frames.shift();
  }

  /** Keeps an image's bytes with its time, s. */
  image(time, buffer) {
    if (time < this.images.at(-1)?.time - CLOCK_ANEW_S) this.images = [];
    this.images.push({ time, buffer });
    while (time - this.images[0].time > KEPT_S) this.images.shift();
  }

  /** The image whose time is nearest to that of `frame`; undefined if there is none. */
  imageOf(frame) {
    const away = ({ time }) => Math.abs(time - frame.time);
    return this.images.reduce((best, image) => (best && away(best) <= away(image) ? best : image), undefined)?.buffer;
  }
}
