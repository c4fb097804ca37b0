for (const picker of document.querySelectorAll(".picker")) {
  const stack = picker.querySelector(".stack");
  const images = stack.querySelectorAll("img");
  picker.querySelectorAll("select").forEach((select, side) => {
    const show = () => {
      const named = [...document.querySelectorAll("img[data-name]")].find((img) => img.dataset.name === select.value);
      if (named) images[side].src = named.src;
    };
    select.addEventListener("change", show);
    show();
  });
  const range = stack.querySelector("input");
  const cut = () => stack.style.setProperty("--cut", range.value + "%");
  range.addEventListener("input", cut);
  cut();
}
