// What can be chosen: the controls of the replay, filled in, and the data that they stand for.
const choice = (() => {
  const NONE = "none"; // in place of a player: no right side
  const CHOSEN = ["condition", "seed", "left", "right"];

  const part = (name) => document.querySelector(`[data-replay="${name}"]`);
  const byKey = (items, key) => Object.fromEntries(items.map((item) => [item[key], item]));
  const conditions = byKey(world.conditions, "name");
  const players = byKey(world.players, "key");
  const names = [...CHOSEN, "speed", "view", "time", "play", "clock"];
  const control = Object.fromEntries(names.map((name) => [name, part(name)]));
  const blocks = {};

  /** The episodes of a condition, parsed when they are first needed. */
  function episodes(condition) {
    const script = `script[data-condition="${CSS.escape(condition)}"]`;
    return (blocks[condition] ??= JSON.parse(document.querySelector(script).textContent));
  }

  /** What a player did in an episode, or null if it is not in the page. */
  function take(condition, seed, key) {
    const block = episodes(condition);
    return block.takes[key]?.[block.seeds.indexOf(seed)] ?? null;
  }

  /** The film that a side shows, or null. */
  async function film(side) {
    const condition = control.condition.value;
    const player = players[control[side].value];
    const found = player ? take(condition, Number(control.seed.value), player.key) : null;
    if (!found) return null;
    const values = await poses.unpack(found);
    return { condition: conditions[condition], player, take: found, poses: values };
  }

  /** Fills in everything but the episodes, which depend on the condition. */
  function fill() {
    const labels = world.players.map(({ key, label }) => [key, label]);
    const titles = world.conditions.map(
      ({ name, about }) => [name, [name, about].filter(Boolean).join(": ")],
    );
    const options = { condition: titles, left: labels, right: [...labels, [NONE, "none"]] };
    for (const [name, pairs] of Object.entries(options)) {
      control[name].replaceChildren(...pairs.map(([value, text]) => new Option(text, value)));
    }
    control.right.value = labels[1]?.[0] ?? NONE;
  }

  /** Lists the episodes of the condition, first those in which a policy failed that should not. */
  function fillSeeds(chosen) {
    const condition = control.condition.value;
    const block = episodes(condition);
    const none = ["No policy", world.trivial.join(" and ")].filter(Boolean).join(" but ");
    const groups = [["A policy", true], [none, false]].map(([who, failed]) => {
      const group = document.createElement("optgroup");
      const seeds = block.seeds.filter((_, k) => block.failed[k] === failed);
      group.label = `${who} failed (${seeds.length})`;
      group.append(...seeds.map((seed) => new Option(describe(condition, seed), seed)));
      return group;
    });
    control.seed.replaceChildren(...groups.filter((group) => group.children.length));
    control.seed.value = block.seeds.includes(chosen) ? chosen : block.seeds[0];
  }

  /** An episode with its outcome, policy by policy. */
  function describe(condition, seed) {
    const marks = world.policies.map((name) => {
      const trainings = world.players.filter(({ policy }) => policy === name);
      const found = trainings.map(({ key }) => take(condition, seed, key)).filter(Boolean);
      const done = found.filter(({ success }) => success).length;
      if (trainings.length > 1) return `${name} ${done}/${found.length}`;
      return found.length ? `${name} ${done ? "✓" : "✗"}` : "";
    });
    return [seed, ...marks.filter(Boolean)].join("  ");
  }

  return { NONE, CHOSEN, part, players, control, film, fill, fillSeeds };
})();
