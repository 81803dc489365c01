// Finds a channel by its name among all that can be charted.
import { h } from '../dom.js';
import { searchList } from './search_list.js';

/** A dialog; open_for(choose) shows it and hands the chosen channel to `choose`. */
export function channelPicker(model) {
  let choose = () => {};
  const { search, rows, fill } = searchList({
    items: model.channels,
    text: ({ name, group, unit }) => `${name} ${group} ${unit}`,
    row: (channel) => h('button.row', {
      type: 'button', role: 'option', 'data-name': channel.name,
      onclick: () => { sheet.close(); choose(channel); },
    }, h('span.name', {}, channel.name), h('span.number', {}, channel.unit), h('span.faint', {}, channel.group)),
    most: 60, name: 'Find a channel', placeholder: `Find one of ${model.channels.length} channels`, list_name: 'Channels', nothing: 'No channel of that name.',
  });
  const sheet = h('dialog.picker', { 'aria-label': 'Add a channel' }, search, rows);
  sheet.addEventListener('click', (event) => { if (event.target === sheet) sheet.close(); });
  sheet.open_for = (then) => {
    choose = then;
    search.value = '';
    fill();
    sheet.showModal();
    search.focus();
  };
  return sheet;
}
