// The stage: one moment of an episode, drawn to scale. A film is an unpacked episode of one player:
// {condition, player, take, poses}, the poses as one array: body by body x, y and heading, each with all
// its times.
const stage = ((palette) => {
  const FONT = '500 12px system-ui, -apple-system, "Segoe UI", Roboto, Arial, sans-serif';
  const MARGIN = 0.15; // m of water round all that moves
  const NEAR = 0.5; // m of water round the vessel in the near view
  const BANDS = 16; // in which a trail fades
  const FRESH = 20; // s for which it hardly does

  /** The pose of a body at a time, between the two that are kept. */
  function pose({ condition, take, poses }, body, time) {
    const { frames, end } = take;
    const now = Math.min(Math.max(time, 0), end);
    const k = Math.max(0, Math.min(Math.floor(now / condition.step), frames - 2));
    const next = Math.min(k + 1, frames - 1);
    const length = (next === frames - 1 ? end : next * condition.step) - k * condition.step;
    const share = length > 0 ? Math.min(1, (now - k * condition.step) / length) : 1;
    return [0, 1, 2].map((axis) => {
      const row = (3 * body + axis) * frames;
      return poses[row + k] + share * (poses[row + next] - poses[row + k]);
    });
  }

  const reach = (outline) => Math.max(...outline.map(([x, y]) => Math.hypot(x, y)));

  /** Of all that moves in some films: west, east, south, north. */
  function bounds(films) {
    const box = [Infinity, -Infinity, Infinity, -Infinity];
    const widen = (x, y, room) => {
      box[0] = Math.min(box[0], x - room);
      box[1] = Math.max(box[1], x + room);
      box[2] = Math.min(box[2], y - room);
      box[3] = Math.max(box[3], y + room);
    };
    for (const { condition, take, poses } of films) {
      const { frames, goal } = take;
      for (let body = 0; body <= condition.boats; body += 1) {
        const room = reach(body ? condition.boat : condition.vessel) + MARGIN;
        const row = 3 * body * frames;
        for (let k = row; k < row + frames; k += 1) widen(poses[k], poses[k + frames], room);
      }
      if (goal) widen(goal[0], goal[1], reach(condition.vessel) + MARGIN);
    }
    return box;
  }

  /** A camera that sees a whole box: where it looks, and pixels a metre. */
  function whole([west, east, south, north], width, height) {
    const scale = Math.min(width / (east - west), height / (north - south));
    return { x: (west + east) / 2, y: (south + north) / 2, scale };
  }

  /** A camera that stays with the vessel. */
  function near(film, time, width, height) {
    const { condition } = film;
    const [x, y] = pose(film, 0, time);
    const room = reach(condition.vessel) + reach(condition.boat) + NEAR;
    return { x, y, scale: Math.min(width, height) / 2 / room };
  }

  /** The largest of 1, 2, 5 times a power of ten that is at most a limit. */
  function roundNumber(limit) {
    const decade = 10 ** Math.floor(Math.log10(limit));
    return [5, 2, 1].map((k) => k * decade).find((number) => number <= limit);
  }

  /** Draws a film at a time, as a camera sees it. */
  function draw(canvas, film, time, eye) {
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const sharp = window.devicePixelRatio || 1;
    canvas.width = Math.round(width * sharp);
    canvas.height = Math.round(height * sharp);
    const pen = canvas.getContext("2d");
    const flat = () => pen.setTransform(sharp, 0, 0, sharp, 0, 0);
    flat();
    drawWater(pen, width, height);
    const m = sharp * eye.scale; // metres from here on, y upwards
    pen.setTransform(m, 0, 0, -m, sharp * width / 2 - m * eye.x, sharp * height / 2 + m * eye.y);
    const px = 1 / eye.scale;
    const bar = roundNumber(width / 4.5 * px);
    drawGrid(pen, eye, width, height, bar, px);
    drawWorld(pen, film, time, px);
    flat();
    drawCaptions(pen, film, time, width);
    drawBar(pen, height, bar, eye.scale);
  }

  function drawWater(pen, width, height) {
    const water = pen.createLinearGradient(0, 0, 0, height);
    water.addColorStop(0, palette.water_top);
    water.addColorStop(1, palette.water_bottom);
    pen.fillStyle = water;
    pen.fillRect(0, 0, width, height);
  }

  function drawGrid(pen, eye, width, height, bar, px) {
    const [wide, high] = [width / 2 * px, height / 2 * px];
    pen.strokeStyle = palette.white;
    pen.globalAlpha = 0.09;
    pen.lineWidth = px;
    pen.beginPath();
    for (let x = Math.ceil((eye.x - wide) / bar) * bar; x < eye.x + wide; x += bar) {
      pen.moveTo(x, eye.y - high);
      pen.lineTo(x, eye.y + high);
    }
    for (let y = Math.ceil((eye.y - high) / bar) * bar; y < eye.y + high; y += bar) {
      pen.moveTo(eye.x - wide, y);
      pen.lineTo(eye.x + wide, y);
    }
    pen.stroke();
    pen.globalAlpha = 1;
  }

  function drawWorld(pen, film, time, px) {
    const { condition } = film;
    if (condition.walls !== null) {
      pen.strokeStyle = palette.quay;
      pen.lineWidth = 4 * px;
      pen.strokeRect(-condition.walls, -condition.walls, 2 * condition.walls, 2 * condition.walls);
    }
    const goal = goalOf(film, time);
    if (goal) drawGoal(pen, condition, goal);
    drawTrail(pen, film, time, px);
    drawVessel(pen, condition, pose(film, 0, time), px);
    if (goal) dashGoal(pen, condition, goal, px);
    for (let boat = 0; boat < condition.boats; boat += 1) drawBoat(pen, film, boat, time, px);
  }

  /** The goal, once it is known: where it is anchored at closure, from closure on. */
  function goalOf({ condition, take }, time) {
    if (!condition.anchored) return take.goal;
    return take.closure !== null && time >= take.closure ? take.goal : null;
  }

  function hull(pen, outline, [x, y, heading], inside) {
    pen.save();
    pen.translate(x, y);
    pen.rotate(heading);
    pen.beginPath();
    outline.forEach(([u, v]) => pen.lineTo(u, v));
    pen.closePath();
    inside();
    pen.restore();
  }

  function fill(pen, colour) {
    pen.fillStyle = colour;
    pen.fill();
  }

  function chevron(pen, outline, colour) {
    const size = 0.6 * Math.min(...outline.map(([, y]) => Math.abs(y)));
    pen.beginPath();
    const arrow = [[0.9, 0], [-0.5, 0.8], [-0.15, 0], [-0.5, -0.8]];
    arrow.forEach(([u, v]) => pen.lineTo(size * u, size * v));
    pen.closePath();
    fill(pen, colour);
  }

  function drawGoal(pen, condition, goal) {
    hull(pen, condition.vessel, goal, () => {
      pen.globalAlpha = 0.17;
      fill(pen, palette.white);
      pen.globalAlpha = 0.6;
      chevron(pen, condition.vessel, palette.white);
      pen.globalAlpha = 1;
    });
  }

  function dashGoal(pen, condition, goal, px) {
    hull(pen, condition.vessel, goal, () => {
      pen.setLineDash([7 * px, 5 * px]);
      pen.strokeStyle = palette.edge;
      pen.lineWidth = 3.4 * px;
      pen.stroke();
      pen.strokeStyle = palette.white;
      pen.lineWidth = 2 * px;
      pen.stroke();
    });
  }

  /** The way of the vessel so far, fading in bands, in a pale shade of the policy's colour. */
  function drawTrail(pen, film, time, px) {
    const { condition, take, poses, player } = film;
    const now = Math.min(time, take.end);
    const last = Math.min(Math.floor(now / condition.step), take.frames - 2);
    const points = [];
    for (let k = 0; k <= last; k += 1) points.push([poses[k], poses[take.frames + k]]);
    points.push(pose(film, 0, now));
    const long = Math.max(1, Math.ceil(points.length / BANDS));
    pen.strokeStyle = `color-mix(in srgb, ${player.colour}, white 55%)`;
    pen.lineWidth = 3 * px;
    pen.lineJoin = "round";
    for (let start = 0; start < points.length - 1; start += long) {
      const age = (now - start * condition.step) / Math.max(now, FRESH);
      pen.globalAlpha = 1 - 0.75 * Math.max(0, Math.min(1, age));
      pen.beginPath();
      points.slice(start, start + long + 1).forEach(([x, y]) => pen.lineTo(x, y));
      pen.stroke();
    }
    pen.globalAlpha = 1;
  }

  function drawShadow(pen, outline, [x, y, heading], px) {
    hull(pen, outline, [x + 1.5 * px, y - 2.2 * px, heading], () => fill(pen, palette.shadow));
  }

  function drawVessel(pen, condition, place, px) {
    drawShadow(pen, condition.vessel, place, px);
    hull(pen, condition.vessel, place, () => {
      fill(pen, palette.deck);
      pen.strokeStyle = palette.keel;
      pen.lineWidth = 1.6 * px;
      pen.stroke();
      chevron(pen, condition.vessel, palette.keel);
    });
  }

  function drawBoat(pen, film, boat, time, px) {
    const { condition, take } = film;
    const place = pose(film, boat + 1, time);
    const died = take.failures[boat];
    const works = died === null || time < died;
    const bow = Math.max(...condition.boat.map(([x]) => x));
    drawShadow(pen, condition.boat, place, 0.7 * px);
    hull(pen, condition.boat, place, () => {
      fill(pen, works ? palette.team[boat % palette.team.length] : palette.failed);
      pen.save();
      pen.clip();
      pen.fillStyle = palette.white;
      pen.globalAlpha = works ? 1 : 0.5;
      pen.fillRect(bow - condition.bow, -bow, condition.bow, 2 * bow);
      pen.restore();
      pen.strokeStyle = palette.edge;
      pen.lineWidth = Math.min(1.2 * px, 0.1 * bow);
      pen.stroke();
      if (!works) cross(pen, 0.7 * Math.max(...condition.boat.map(([, y]) => y)), px);
    });
  }

  function cross(pen, condition, px) {
    pen.strokeStyle = palette.mark;
    pen.lineWidth = Math.max(1.5 * px, 0.28 * condition);
    pen.beginPath();
    for (const sign of [-1, 1]) {
      pen.moveTo(-condition, -sign * condition);
      pen.lineTo(condition, sign * condition);
    }
    pen.stroke();
  }

  function write(pen, text, x, y, align, colour) {
    pen.font = FONT;
    pen.textBaseline = "middle";
    pen.textAlign = align;
    pen.lineWidth = 3;
    pen.lineJoin = "round";
    pen.strokeStyle = palette.edge;
    pen.globalAlpha = 0.55;
    pen.strokeText(text, x, y);
    pen.globalAlpha = 1;
    pen.fillStyle = colour;
    pen.fillText(text, x, y);
  }

  function drawCaptions(pen, film, time, width) {
    const { take } = film;
    const colour = time >= take.end && take.success ? palette.good : palette.ink;
    write(pen, phase(film, time), 14, 18, "left", colour);
    write(pen, `${Math.min(time, take.end).toFixed(1)} s`, width - 14, 18, "right", palette.ink);
  }

  /** A bar of so many metres. */
  function drawBar(pen, height, bar, scale) {
    const [start, end, row] = [14, 14 + bar * scale, height - 18];
    pen.strokeStyle = palette.ink;
    pen.lineWidth = 2;
    pen.beginPath();
    pen.moveTo(start, row - 5);
    pen.lineTo(start, row);
    pen.lineTo(end, row);
    pen.lineTo(end, row - 5);
    pen.stroke();
    write(pen, `${Number(bar.toPrecision(1))} m`, end + 8, row - 1, "left", palette.ink);
  }

  /** What the boats of an episode are doing. */
  function phase({ condition, take }, time) {
    if (time >= take.end) return take.verdict;
    if (condition.grasped) return "pushing";
    if (take.closure === null || time < take.closure) return "approaching";
    return `closed at ${take.closure.toFixed(1)} s`;
  }

  return { bounds, whole, near, draw };
})(world.palette);
