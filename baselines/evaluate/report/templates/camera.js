// Cameras: {x, y, scale}, the point in the middle of the picture, m, and pixels a metre.
const camera = (() => {
  const MARGIN = 0.15; // m of water around all that moves
  const NEAR = 0.5; // m of water around the vessel in the near view

  const reach = (outline) => Math.max(...outline.map(([x, y]) => Math.hypot(x, y)));

  /** Points [x, y, radius] of an obstacle. */
  const points = (rows) => rows.flatMap(([ax, ay, bx = ax, by = ay, radius = 0]) =>
    [[ax, ay, radius], [bx, by, radius]]);

  /** The box of all that moves in some films, widened a bit by obstacles: west, east, south, north,
      m. */
  function bounds(films) {
    let [west, east, south, north] = [Infinity, -Infinity, Infinity, -Infinity];
    const include = (x, y, room) => {
      [west, east] = [Math.min(west, x - room), Math.max(east, x + room)];
      [south, north] = [Math.min(south, y - room), Math.max(north, y + room)];
    };
    for (const { condition, take, poses: values } of films) {
      const { frames, goal } = take;
      for (let body = 0; body <= condition.boats; body += 1) {
        const room = reach(body ? condition.boat : condition.vessel) + MARGIN;
        const row = 3 * body * frames;
        for (let k = row; k < row + frames; k += 1) include(values[k], values[k + frames], room);
      }
      if (goal) include(goal[0], goal[1], reach(condition.vessel) + MARGIN);
    }
    const room = Math.max(0, ...films.map(({ condition }) => 2 * reach(condition.vessel)));
    const within = (value, low, high) => Math.min(Math.max(value, low - room), high + room);
    const box = [west, east, south, north];
    for (const [x, y, radius] of films.flatMap(({ take }) => take.obstacles.flatMap(points))) {
      const [clipped, high] = [within(x, box[0], box[1]), within(y, box[2], box[3])];
      include(clipped, high, clipped === x && high === y ? radius : 0);
    }
    return [west, east, south, north];
  }

  /** The camera that sees a whole box. */
  function whole([west, east, south, north], width, height) {
    const scale = Math.min(width / (east - west), height / (north - south));
    return { x: (west + east) / 2, y: (south + north) / 2, scale };
  }

  /** The camera that follows the vessel of a film. */
  function near(film, time, width, height) {
    const [x, y] = poses.at(film, 0, time);
    const room = reach(film.condition.vessel) + reach(film.condition.boat) + NEAR;
    return { x, y, scale: Math.min(width, height) / 2 / room };
  }

  return { bounds, whole, near };
})();
