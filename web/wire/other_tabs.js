// @ts-check
/*
 * Tabs of this browser that are in the same room: one that plays there tells the seat tokens to one that asks, such as
 * a tab in which somebody has opened the invitation again.
 */

const CHANNEL = "movingout.seats";
const PATIENCE_MS = 500; // a tab that lives answers within a few; one that the system has frozen does not

/**
 * @typedef {{room: string, ask?: true, tokens?: string[]}} Message  `ask`: who plays here? `tokens`: this tab does
 */

/** Whether the browser has channels between tabs: Safari before 15.4 has none. */
const hasChannels = () => "BroadcastChannel" in globalThis;

/**
 * Answers every tab that asks who plays in `room`, from now on.
 * @param {string} room @param {() => string[]} tokens  of this tab's seats now; empty: it does not play there
 */
export function answerOtherTabs(room, tokens) {
  if (!hasChannels()) return;
  const channel = new BroadcastChannel(CHANNEL);
  channel.addEventListener("message", (/** @type {MessageEvent<Message>} */ { data }) => {
    if (!data.ask || data.room !== room) return;
    const held = tokens();
    if (held.length > 0) channel.postMessage({ room, tokens: held });
  });
}

/**
 * The seat tokens of another tab that plays in `room`; empty where none says so within half a second.
 * @param {string} room @returns {Promise<string[]>}
 */
export function askOtherTabs(room) {
  if (!hasChannels()) return Promise.resolve([]);
  const channel = new BroadcastChannel(CHANNEL);
  /** @type {Promise<string[]>} */
  const answer = new Promise((done) => {
    setTimeout(() => done([]), PATIENCE_MS);
    channel.addEventListener("message", (/** @type {MessageEvent<Message>} */ { data }) => {
      if (data.room === room && data.tokens) done(data.tokens);
    });
  });
  channel.postMessage({ room, ask: true });
  return answer.finally(() => channel.close());
}
