// Counters in plain words, each with its meaning.

/** Name in a frame, words, meaning; `bad` marks those that should be zero. First those that anybody needs. */
export const PLAIN = [
  ['turns', 'estimates', 'Estimates since the start, one for each frame.'],
  ['tracking', 'with the surface seen', 'Estimates for which the camera saw the surface of the liquid.'],
  ['coasting', 'without the surface', 'Estimates by the model alone: no frame came, or the liquid was not seen.'],
  ['halted', 'none given', 'Nothing was seen for more than a second, so no estimate was given.', 'bad'],
  ['deadline_missed', 'frames without an estimate in time', 'Late, lost and never handled frames together.', 'bad'],
];

/** Then the technical ones, folded away. */
export const TECHNICAL = [
  ['frames_taken', 'frames of the camera', 'Frames that the camera took, by its own clock.'],
  ['over_s', 'time of those frames, s', 'Seconds that the counts of frames cover.'],
  ['frames_late', 'frames handled late', 'The estimate came after the next frame was due.', 'bad'],
  ['frames_lost', 'frames lost', 'No pair of whole images came.', 'bad'],
  ['frames_never_handled', 'frames never handled', 'Due while this machine stood still, or dropped because no buffer was free.', 'bad'],
  ['frames_missing', 'gaps in the frame numbers', 'Frames that the camera counted and that never came.'],
  ['frames_stale', 'frames after their turn', 'They came too late for their turn.'],
  ['frames_caught_up', 'of these, frames used', 'The turn was taken again with the frame, before the next one. The others were dropped.'],
  ['not_seen', 'turns with no liquid in sight', 'A frame came, and the reader found no liquid in it.'],
  ['field_shed', 'turns without a field', 'Velocity and stresses were left out to keep the deadline.', 'bad'],
  ['viewers', 'open pages', 'Browsers that show this page now.'],
  ['left_out', 'frames left out of this page', 'The page was slower than the run; the run does not wait.'],
  ['energy_residual', 'energy balance error', 'Change of energy in a step less the work of the glass, relative to the energy scale: rounding alone.'],
];

/** Table of the counters `of` in the list `list`; returns a function that fills it from a frame. */
export function counters(list, of) {
  const cells = of.map(([, words, meaning]) => {
    const row = document.createElement('div');
    row.append(document.createElement('dt'), document.createElement('dd'));
    row.firstChild.textContent = words;
    row.title = meaning;
    list.append(row);
    return row;
  });
  return (frame) => of.forEach(([name, , , bad], k) => {
    const number = frame[name];
    cells[k].lastChild.textContent = name === 'energy_residual' ? number.toExponential(0) : number;
    cells[k].classList.toggle('bad', Boolean(bad) && number > 0);
  });
}
