// The emergency stop on pages that show no live state: presses it, and says what came of it.

const answer = document.getElementById("stop-answer");

document.getElementById("stop").addEventListener("click", async () => {
  answer.textContent = "Stopping …";
  try {
    const response = await fetch("/api/stop", { method: "PUT" });
    const body = await response.json();
    answer.textContent = response.ok ? "Stopped. Clear it on the drive sheet." : `Failed: ${body.detail}`;
  } catch (error) {
    answer.textContent = `Failed: the dashboard does not answer (${error.message}). Use passafe stop, or the robot's own switch.`;
  }
});
