// The bases of the full field, and the field of a turn from its coefficients: rest + sum of c_j scale_j column_j.

/** What can be seen in colour. `of` gives the value of tracer k; `from` names the groups that it needs. */
export const FIELDS = [
  { name: 'speed', unit: 'm/s', half: 'v_half', factor: 1, from: ['v'], of: ({ v }, k) => Math.hypot(v[3 * k], v[3 * k + 1], v[3 * k + 2]) },
  { name: 'displacement', unit: 'mm', half: 'q_half', factor: 1e3, from: ['q'],
    of: ({ q }, k, rest) => 1e3 * Math.hypot(q[3 * k] - rest.q[3 * k], q[3 * k + 1] - rest.q[3 * k + 1], q[3 * k + 2] - rest.q[3 * k + 2]) },
  { name: 'pressure', unit: 'Pa', half: 'sigma_half', factor: 1, from: ['sigma'], of: ({ sigma }, k) => -(sigma[3 * k] + sigma[3 * k + 1] + sigma[3 * k + 2]) / 3 },
  { name: 'shear stress', unit: 'Pa', half: 'tau_half', factor: 1, from: ['tau'], of: ({ tau }, k) => Math.hypot(tau[3 * k], tau[3 * k + 1], tau[3 * k + 2]) },
  { name: 'internal energy', unit: 'J/kg', half: 'e_half', factor: 1, from: ['e'], of: ({ e }, k, rest) => e[k] - rest.e[k] },
];

export class Model {
  /** From the bytes of `/model`. */
  constructor(buffer) {
    const view = new DataView(buffer);
    const length = view.getUint32(0, true);
    this.facts = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
    let at = 4 + length;
    const take = (Kind, count) => {
      const part = new Kind(buffer, at, count);
      at += part.byteLength;
      return part;
    };
    this.groups = {};
    this.rest = {};
    this.now = {};
    let first = 0;
    for (const { name, numbers, rank } of this.facts.groups) {
      this.rest[name] = take(Float32Array, numbers);
      const scales = take(Float32Array, rank);
      const basis = take(Int16Array, numbers * rank);
      at += -at & 3;
      this.groups[name] = { numbers, rank, scales, basis, first };
      this.now[name] = Float32Array.from(this.rest[name]);
      first += rank;
    }
    this.coefficients = first;
    this.tracers = this.facts.tracers;
    this.values = new Float32Array(this.tracers);
  }

  /** Writes group `name` of the turn with these coefficients. */
  decode(name, coefficients) {
    const { numbers, rank, scales, basis, first } = this.groups[name];
    const out = this.now[name];
    out.set(this.rest[name]);
    for (let j = 0; j < rank; j++) {
      const weight = coefficients[first + j] * scales[j];
      const start = j * numbers;
      for (let k = 0; k < numbers; k++) out[k] += weight * basis[start + k];
    }
    return out;
  }

  /** Whether the model knows every group that `field` is made from. */
  knows(field) {
    return field.from.every((name) => this.facts.groups.some((group) => group.name === name && group.known));
  }

  /** Positions and, in `values`, the chosen field; gives its least and its largest value. Without a field all values are 0. */
  field(field, coefficients) {
    this.decode('q', coefficients);
    if (!field) { this.values.fill(0); return [0, 1]; }
    for (const name of field.from) if (name !== 'q') this.decode(name, coefficients);
    let [low, high] = [Infinity, -Infinity];
    for (let k = 0; k < this.tracers; k++) {
      const value = field.of(this.now, k, this.rest);
      this.values[k] = value;
      if (value < low) low = value;
      if (value > high) high = value;
    }
    return [low, high];
  }

  /** A frame's bytes: mode, flags, number, time, the numbers by name, the profiles by name, the coefficients. */
  frame(buffer) {
    const { numbers, profiles, abscissae } = this.facts;
    const points = abscissae.length;
    const wanted = 16 + 8 * numbers.length + 4 * (profiles.length * points + this.coefficients);
    if (buffer.byteLength !== wanted) throw new Error(`a frame of ${buffer.byteLength} bytes, not ${wanted}`);
    const view = new DataView(buffer);
    const [mode, flags] = [view.getUint8(1), view.getUint8(2)];
    const of = new Float64Array(buffer, 16, numbers.length);
    let at = 16 + 8 * numbers.length;
    const frame = {
      mode: ['filling', 'tracking', 'coasting', 'halted'][mode],
      fieldFresh: (flags & 1) !== 0, frameCame: (flags & 2) !== 0, seen: (flags & 4) !== 0,
      number: view.getUint32(4, true), time: view.getFloat64(8, true), profiles: {},
    };
    numbers.forEach((name, k) => { frame[name] = of[k]; });
    for (const name of profiles) {
      frame.profiles[name] = new Float32Array(buffer, at, points);
      at += 4 * points;
    }
    frame.coefficients = new Float32Array(buffer, at, this.coefficients);
    return frame;
  }
}
