// The keyboard. Fields that take text keep their keys.

const kZoom = 1.25;
const kTurn = Math.PI / 18;
const kSlide = 0.1; // of the picture's height

export function listenToKeys(view, model, act) {
  const flip = (key) => view.set({ show: { ...view.show, [key]: !view.show[key] } });
  const keys = {
    ' ': act.toggle,
    ArrowLeft: (event) => act.step(event.shiftKey ? -10 : -1),
    ArrowRight: (event) => act.step(event.shiftKey ? 10 : 1),
    Home: act.first,
    End: act.last,
    '+': () => act.faster(1),
    '=': () => act.faster(1),
    '-': () => act.faster(-1),
    l: () => view.set({ loop: !view.loop }),
    f: act.fit,
    F: act.fitSelected,
    0: act.home,
    1: () => act.along(0),
    2: () => act.along(1),
    3: () => act.along(2),
    z: () => act.zoom(kZoom),
    Z: () => act.zoom(1 / kZoom),
    x: () => act.turn(kTurn, 0),
    X: () => act.turn(-kTurn, 0),
    y: () => act.turn(0, kTurn),
    Y: () => act.turn(0, -kTurn),
    v: () => act.slide(kSlide, 0),
    V: () => act.slide(-kSlide, 0),
    b: () => act.slide(0, kSlide),
    B: () => act.slide(0, -kSlide),
    o: act.parallel,
    w: act.follow,
    '[': () => act.next(-1),
    ']': () => act.next(1),
    Escape: act.nothing,
    e: () => flip('edges'),
    q: () => flip('elements'),
    j: () => flip('joints'),
    m: () => flip('markers'),
    p: () => flip('traces'),
    r: () => flip('reactions'),
    k: () => flip('contacts'),
    n: () => flip('labels'),
    '/': act.find,
    a: act.addChannel,
    c: act.toggleCharts,
    g: act.toggleSide,
    t: () => view.set({ theme: view.theme === 'dark' ? 'light' : 'dark' }),
    '?': act.help,
  };
  window.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { target } = event;
    if (document.querySelector('dialog[open]')) return;
    const writes = target.matches?.('input[type=search], input[type=text], input[type=number], select, textarea');
    if (writes && event.key !== 'Escape') return;
    const slides = target.matches?.('input[type=range]') && target.id !== 'time';
    if (slides && /^(Arrow|Home|End)/.test(event.key)) return;
    // Space and enter press a focused button; on the scene and elsewhere space plays.
    if (event.key === ' ' && target.matches?.('button, input[type=checkbox], [role=button]')) return;
    const digit = event.shiftKey && /^Digit([1-9])$/.exec(event.code)?.[1];
    if (digit && model.runs.length > 1 && digit <= model.runs.length) {
      view.set({ runs: view.runs.map((run, i) => (i === digit - 1 ? { ...run, shown: !run.shown } : run)) });
      event.preventDefault();
      return;
    }
    const action = keys[event.key];
    if (!action) return;
    action(event);
    event.preventDefault();
  });
}
