// Remedies name commands of `thimble`. Where this page has a button or a panel for one, it is named instead.
const kHere: Record<string, string> = {
  'thimble home': 'the button "Home"',
  'thimble arm': 'the button "Arm"',
  'thimble disarm': 'the button "Disarm"',
  'thimble stop': 'the button "Stop"',
  'thimble fault clear': 'the button "Clear fault"',
  'thimble fault list': 'the panel "Messages"',
  'thimble param list': 'the panel "Parameters"',
  'thimble upload': 'the button "Load"',
};

export const on_this_page = (remedy: string): string => remedy.replace(/`([^`]+)`/g, (whole, command: string) => kHere[command] ?? whole);
