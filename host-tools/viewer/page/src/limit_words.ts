// What holds the force back, in words; the names are those of link::Limiter in firmware/link/messages.def.
export const kLimits: Record<string, { short: string; long: string }> = {
  clamp: { short: 'largest force', long: 'it is as large as the arm may make it ("clamp")' },
  slew: { short: 'fastest change', long: 'it changes as fast as it may ("slew")' },
  current: { short: 'motor current', long: 'a motor has the most current that it may have' },
  thermal: { short: 'motor heat', long: 'a motor is hot, and is spared ("thermal")' },
  probe: { short: 'encoder check', long: 'for a moment less is given, to see whether the encoders of the joints still count ("probe")' },
  work: { short: 'time of a tick', long: 'the scene takes longer than a tick; the rest of it comes a tick later ("work")' },
  singular: { short: "arm's pose", long: 'the arm is nearly straight or folded, and cannot push in every direction ("singular")' },
};

export const limits_text = (names: readonly string[]): string => names.map((name) => kLimits[name]?.short ?? name).join(', ') || 'nothing';
