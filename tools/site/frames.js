// Frames with a model are as high as their content where that is in one column, so that only the page scrolls.
addEventListener("message", ({ source, data }) => {
  const height = data?.foldwingHeight;
  if (!Number.isFinite(height)) return;
  for (const frame of document.querySelectorAll("iframe.live-model")) {
    // 0: the content has the height of the frame
    if (frame.contentWindow === source) frame.style.height = height > 0 ? `${Math.ceil(height) + 2}px` : "";
  }
});
