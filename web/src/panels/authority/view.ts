/** Texts about authority; pure. */

import type { AuthorityState } from '../../record/types';

/** `pilot in command`. */
export function roleText(role: string): string {
  return role.replaceAll('-', ' ');
}

/** `free`, `you`, `tower (operator)`, `tower (operator), silent`. */
export function holderText(authority: AuthorityState): string {
  if (authority.holder === null) return 'free';
  if (authority.yours) return 'you';
  const silent = authority.silent ? ', silent' : '';
  return `${authority.holder.name} (${roleText(authority.holder.role)})${silent}`;
}

/** The open offer, as `offered to you for 42 s`; null if there is none. */
export function offerText(authority: AuthorityState): string | null {
  if (authority.offer === null) return null;
  const to = isOfferedToYou(authority) ? 'you' : authority.offer.to;
  return `offered to ${to} for ${Math.ceil(authority.offer.left_s)} s`;
}

export function isOfferedToYou(authority: AuthorityState): boolean {
  return authority.offer?.to === authority.you.name;
}
