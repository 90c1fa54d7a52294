// The keyboard.

const TURN = 0.1;
const ZOOM = 1.12;

/** What each key does; `shift` makes steps in time longer. */
export function listen({ player, stage, actions }) {
  const keys = {
    " ": () => player.toggle(),
    ArrowLeft: (shift) => player.step(shift ? -1 : -0.1),
    ArrowRight: (shift) => player.step(shift ? 1 : 0.1),
    Home: () => player.seek(0),
    End: () => player.seek(player.duration),
    p: () => player.toMark(-1),
    n: () => player.toMark(1),
    "+": () => player.faster(1),
    "=": () => player.faster(1),
    "-": () => player.faster(-1),
    1: () => stage.look("all"),
    2: () => stage.look("hand"),
    3: () => stage.look("top"),
    f: actions.follow,
    a: () => stage.turn(-TURN, 0, 1),
    d: () => stage.turn(TURN, 0, 1),
    w: () => stage.turn(0, TURN, 1),
    s: () => stage.turn(0, -TURN, 1),
    e: () => stage.turn(0, 0, 1 / ZOOM),
    q: () => stage.turn(0, 0, ZOOM),
    t: actions.theme,
    "?": actions.help,
  };
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const own = event.target.closest("select, dialog");
    const pressed = event.key === " " && event.target.closest("button");
    const act = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (own || pressed || !act) return;
    event.preventDefault();
    act(event.shiftKey);
  });
}
