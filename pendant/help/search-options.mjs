// How the pages are indexed and searched; the browser reads the index with the same options.
export const searchOptions = {
  fields: ['title', 'page', 'text'],
  storeFields: ['href', 'page', 'title', 'text'],
  searchOptions: { boost: { title: 4, page: 2 }, prefix: true, fuzzy: 0.15, combineWith: 'AND' },
};
