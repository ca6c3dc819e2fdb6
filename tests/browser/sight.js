// What somebody sees on the game page: the words, and blobs of colour on the arena. Knows nothing of the game's state.
window.__sight = () => {
  const canvas = document.querySelector("#arena");
  const { width, height } = canvas;
  const picture = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
  picture.drawImage(canvas, 0, 0);
  const { data } = picture.getImageData(0, 0, width, height);
  const style = getComputedStyle(document.documentElement);
  const look = (name) => {
    const hex = style.getPropertyValue(name).trim();
    const [r, g, b] = [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
    const rows = new Uint32Array(height);
    let [count, x, y] = [0, 0, 0];
    for (let at = 0; at < data.length; at += 4) {
      if (Math.abs(data[at] - r) + Math.abs(data[at + 1] - g) + Math.abs(data[at + 2] - b) > 18) continue;
      const [px, py] = [(at / 4) % width, Math.floor(at / 4 / width)];
      [count, x, y] = [count + 1, x + px, y + py];
      rows[py] += 1;
    }
    const bottom = rows.findLastIndex((pixels) => pixels > width / 8); // a stray pixel is no area
    return { count, x: x / count / width, y: y / count / height, bottom: bottom / height };
  };
  return {
    words: document.querySelector(".tutorial-words")?.textContent ?? "",
    end: document.querySelector("#arena-box .overlay:not([hidden]) h2")?.textContent ?? "",
    me: look("--blue"),
    glow: look("--attention"),
    home: look("--goal"),
  };
};
