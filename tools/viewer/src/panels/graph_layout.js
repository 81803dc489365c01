// Places the system graph once: distances in the drawing as near as can be to the number of steps between the nodes
// (stress, by gradient steps over pairs: Zheng, Pawar & Goodman 2019), then boxes are pushed apart.

export const kMostDrawnBodies = 80;
const kStep = 46; // pixels between a body and its connector

/** A sequence that is the same in every browser and at every visit. */
function lottery(seed) {
  let state = seed;
  return () => {
    state = (state * 1664525 + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

function stepsFrom(start, neighbours) {
  const steps = new Array(neighbours.length).fill(Infinity);
  steps[start] = 0;
  const queue = [start];
  for (let head = 0; head < queue.length; ++head) {
    for (const next of neighbours[queue[head]]) {
      if (steps[next] === Infinity) {
        steps[next] = steps[queue[head]] + 1;
        queue.push(next);
      }
    }
  }
  return steps;
}

function relax(nodes, neighbours, draw) {
  const pairs = [];
  nodes.forEach((_, i) => {
    const steps = stepsFrom(i, neighbours);
    for (let j = i + 1; j < nodes.length; ++j) {
      // Parts that are not joined lie side by side.
      const distance = kStep * (Number.isFinite(steps[j]) ? steps[j] : 4 + Math.sqrt(nodes.length));
      pairs.push({ a: nodes[i], b: nodes[j], distance, weight: 1 / (distance * distance) });
    }
  });
  const kRounds = 40;
  const largest = 1 / Math.min(...pairs.map((pair) => pair.weight));
  const smallest = 0.1 / Math.max(...pairs.map((pair) => pair.weight));
  const fall = Math.log(smallest / largest) / (kRounds - 1);
  for (let round = 0; round < kRounds; ++round) {
    const pace = largest * Math.exp(fall * round);
    for (let i = pairs.length - 1; i > 0; --i) {
      const j = Math.floor(draw() * (i + 1));
      [pairs[i], pairs[j]] = [pairs[j], pairs[i]];
    }
    for (const { a, b, distance, weight } of pairs) {
      const dx = a.x - b.x;
      const dy = a.y - b.y;
      const length = Math.hypot(dx, dy) || 1e-6;
      const move = (0.5 * Math.min(1, pace * weight) * (length - distance)) / length;
      a.x -= move * dx;
      a.y -= move * dy;
      b.x += move * dx;
      b.y += move * dy;
    }
  }
}

/** Turns the drawing so that the root is on top, or at the left where it is wider than high that way. */
function upright(nodes, root) {
  const centre = (key) => nodes.reduce((sum, node) => sum + node[key], 0) / nodes.length;
  const [cx, cy] = [centre('x'), centre('y')];
  const angle = Math.atan2(cy - root.y, cx - root.x);
  const turn = Math.PI / 2 - (Number.isFinite(angle) ? angle : 0);
  const [c, s] = [Math.cos(turn), Math.sin(turn)];
  for (const node of nodes) {
    const [x, y] = [node.x - cx, node.y - cy];
    node.x = c * x - s * y;
    node.y = s * x + c * y;
  }
}

/** Spreads the drawing, more across since boxes are wide, until all boxes would fit in it twice over. */
function spread(nodes) {
  const extent = (key) => Math.max(...nodes.map((node) => node[key])) - Math.min(...nodes.map((node) => node[key])) + 1;
  const boxes = nodes.reduce((sum, node) => sum + (node.width + 10) * (node.height + 8), 0);
  const factor = Math.sqrt((2 * boxes) / (extent('x') * extent('y')));
  if (!(factor > 1) || nodes.length < 12) return;
  for (const node of nodes) {
    node.x *= 1.25 * factor;
    node.y *= 0.8 * factor;
  }
}

function separate(nodes) {
  for (let round = 0; round < 60; ++round) {
    let moved = false;
    for (let i = 0; i < nodes.length; ++i) {
      for (let j = i + 1; j < nodes.length; ++j) {
        const [a, b] = [nodes[i], nodes[j]];
        const over_x = (a.width + b.width) / 2 + 10 - Math.abs(a.x - b.x);
        const over_y = (a.height + b.height) / 2 + 8 - Math.abs(a.y - b.y);
        if (over_x <= 0 || over_y <= 0) continue;
        moved = true;
        if (over_x < over_y) {
          const push = (0.5 * over_x + 0.1) * (a.x <= b.x ? -1 : 1);
          a.x += push;
          b.x -= push;
        } else {
          const push = (0.5 * over_y + 0.1) * (a.y <= b.y ? -1 : 1);
          a.y += push;
          b.y -= push;
        }
      }
    }
    if (!moved) return;
  }
}

/** nodes: {width, height, root?}; links: pairs of indices. Sets x and y of every node, the centre of its box. */
export function placeGraph(nodes, links) {
  if (!nodes.length) return;
  const draw = lottery(7);
  const neighbours = nodes.map(() => []);
  for (const [a, b] of links) {
    neighbours[a].push(b);
    neighbours[b].push(a);
  }
  const root = Math.max(0, nodes.findIndex((node) => node.root));
  const steps = stepsFrom(root, neighbours);
  nodes.forEach((node, i) => {
    node.x = 200 * (draw() - 0.5);
    node.y = kStep * (Number.isFinite(steps[i]) ? steps[i] : 0);
  });
  if (nodes.length > 1) relax(nodes, neighbours, draw);
  upright(nodes, nodes[root]);
  spread(nodes);
  separate(nodes);
}
