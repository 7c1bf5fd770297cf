{
  // A film is its still until it is started, for those who want no motion above all. Where the
  // browser decodes GIFs frame by frame, it is painted on a canvas and pauses; elsewhere it is shown.
  const data = {};
  const beside = (name) => new Promise((done, failed) => {
    const script = document.createElement("script");
    window.filmData = (uri) => { data[name] = uri; };
    script.src = `${name}.js`;
    script.onload = () => done(data[name]);
    script.onerror = failed;
    document.head.append(script);
  });
  const opened = async (gif) => {
    const uri = gif.startsWith("data:") ? gif : await beside(gif);
    const bytes = await (await fetch(uri)).arrayBuffer();
    const decoder = new ImageDecoder({ data: bytes, type: "image/gif" });
    await Promise.all([decoder.completed, decoder.tracks.ready]);
    return decoder;
  };
  for (const film of document.querySelectorAll(".film")) {
    const [play, stop] = film.querySelectorAll("button"), image = film.querySelector("img");
    const still = image.src, title = image.alt;
    let canvas, decoder, running = 0, frame = 0;
    const say = (word) => {
      play.textContent = word;
      play.setAttribute("aria-label", `${word}: ${title}`);
    };
    const run = async () => {
      const mine = ++running;
      say("Pause");
      for (const count = decoder.tracks.selectedTrack.frameCount; ; frame = (frame + 1) % count) {
        const { image: picture } = await decoder.decode({ frameIndex: frame });
        if (running !== mine) return picture.close();
        [canvas.width, canvas.height] = [picture.displayWidth, picture.displayHeight];
        canvas.getContext("2d").drawImage(picture, 0, 0);
        canvas.dataset.frame = frame;
        const wait = picture.duration / 1000;
        picture.close();
        await new Promise((done) => setTimeout(done, wait));
        if (running !== mine) return undefined;
      }
    };
    const pause = () => { running += 1; say("Play"); };
    const halt = () => {
      pause();
      frame = 0;
      canvas?.remove();
      if (image.src !== still) image.src = still;
      image.hidden = play.hidden = false;
      stop.hidden = true;
    };
    play.addEventListener("click", async () => {
      if (play.textContent === "Pause") return pause();
      stop.hidden = false;
      try {
        const asked = ++running;
        decoder ??= await opened(film.dataset.gif);
        if (running !== asked) return undefined;
        canvas ??= document.createElement("canvas");
        canvas.setAttribute("role", "img");
        canvas.setAttribute("aria-label", title);
        image.after(canvas);
        image.hidden = true;
        return await run();
      } catch {
        image.src = film.dataset.gif;
        play.hidden = true;
        return stop.focus();
      }
    });
    stop.addEventListener("click", () => { halt(); play.focus(); });
    matchMedia("(prefers-reduced-motion: reduce)").addEventListener("change", (now) => {
      if (now.matches) halt();
    });
  }
}
