// The way to the program: the bases first, then frames; a connection that breaks is made again, ever more slowly.

import { Model } from './field.js';

const FIRST_WAIT_MS = 250;
const LONGEST_WAIT_MS = 4000;

export class Connection {
  /** `on`: model(Model), frame(object), image(ArrayBuffer), state(name, words). */
  constructor(on) {
    this.on = on;
    this.rate = 60;
    /** 0 the image of the outline, 1 of the depth. */
    this.image = 0;
    this.wait = FIRST_WAIT_MS;
    this.bytes = 0;
    this.token = new URLSearchParams(location.search).get('token');
  }

  address(path) {
    return this.token === null ? path : `${path}?token=${encodeURIComponent(this.token)}`;
  }

  async open() {
    try {
      const answer = await fetch(this.address('/model'), { cache: 'no-store', signal: AbortSignal.timeout(15000) });
      if (answer.status === 403) {
        this.on.state('refused', 'The token in this page\'s address is no longer right: the program was started anew. Open the address that it printed.');
        return this.later(LONGEST_WAIT_MS);
      }
      if (!answer.ok) throw new Error(`${answer.status}`);
      this.model = new Model(await answer.arrayBuffer());
    } catch {
      return this.broken();
    }
    this.on.model(this.model);
    const socket = new WebSocket(new URL(this.address('/live'), location.href).href.replace(/^http/, 'ws'));
    this.socket = socket;
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => this.taken(0);
    socket.onmessage = ({ data }) => this.message(data);
    socket.onclose = ({ reason }) => this.broken(reason);
  }

  message(data) {
    // Text is what happened to the camera.
    if (typeof data === 'string') return this.on.note(data);
    this.bytes += data.byteLength;
    if (new Uint8Array(data, 0, 1)[0] === 2) return this.on.image(data);
    this.wait = FIRST_WAIT_MS;
    const frame = this.model.frame(data);
    // Reported before it is drawn, but only when this page has time: a page that has none gets fewer frames.
    this.taken(frame.number);
    this.on.frame(frame);
  }

  taken(number) {
    const message = new DataView(new ArrayBuffer(8));
    message.setUint32(0, number, true);
    message.setUint8(4, this.rate);
    message.setUint8(5, this.image);
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(message.buffer);
  }

  broken(reason) {
    this.socket = undefined;
    this.on.state('lost', reason ? `Connection closed: ${reason}.` : 'The program cannot be reached.');
    this.later(this.wait);
    this.wait = Math.min(2 * this.wait, LONGEST_WAIT_MS);
  }

  later(wait) {
    // A little chance, so that many pages do not come back in the same instant.
    setTimeout(() => this.open(), wait * (0.75 + 0.5 * Math.random()));
  }
}
