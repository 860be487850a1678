// Poses of an embedded episode. A take is what one player did in an episode, as replay.py wrote it.
// A film is an unpacked take: {condition, player, take, poses}, its poses one array: body by body x,
// y and heading, each with the values of all frames.
const poses = ((units) => {
  async function inflate(text) {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  /** The poses of a take; the inverse of ``pack`` in replay.py. */
  async function unpack({ poses: packed, frames }) {
    const bytes = await inflate(packed);
    const count = bytes.length / 2;
    const values = new Float32Array(count);
    let [step, value] = [0, 0];
    for (let k = 0; k < count; k += 1) {
      if (k % frames === 0) step = value = 0;
      const unsigned = bytes[k] | (bytes[count + k] << 8);
      step += (unsigned >>> 1) ^ -(unsigned & 1);
      value += step;
      values[k] = value * units[Math.floor(k / frames) % 3];
    }
    return values;
  }

  /** The pose [x, y, heading] of a body at a time, interpolated between two frames. */
  function at({ condition, take, poses: values }, body, time) {
    const { frames, end } = take;
    const now = Math.min(Math.max(time, 0), end);
    const k = Math.max(0, Math.min(Math.floor(now / condition.step), frames - 2));
    const next = Math.min(k + 1, frames - 1);
    const length = (next === frames - 1 ? end : next * condition.step) - k * condition.step;
    const share = length > 0 ? Math.min(1, (now - k * condition.step) / length) : 1;
    return [0, 1, 2].map((axis) => {
      const row = (3 * body + axis) * frames;
      return values[row + k] + share * (values[row + next] - values[row + k]);
    });
  }

  /** The positions of the vessel from the first frame to a time. */
  function path(film, time) {
    const { take, condition, poses: values } = film;
    const last = Math.min(Math.floor(time / condition.step), take.frames - 2);
    const frame = (_, k) => [values[k], values[take.frames + k]];
    return [...Array.from({ length: last + 1 }, frame), at(film, 0, time)];
  }

  return { unpack, at, path };
})(world.units);
